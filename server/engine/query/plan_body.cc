#include "core/export/motion_writer.h"
#include "core/format/gunzip.h"
#include "core/kinematics/marker_kinematics.h"
#include "core/mapping/fit_scheme.h"
#include "core/motion/error.h"
#include "core/motion/marker_set.h"
#include "server/engine/ingest.h"
#include "server/engine/query/plan_query.h"
#include "server/engine/source_reader.h"

namespace motiondb::server {
namespace {

using core::AtField;
using core::FieldViolation;

constexpr int kMaxListedSkeletons = 10;
// Limits of a body: inverse kinematics is quadratic and cubic in the degrees of freedom, and every
// frame has all of them.
constexpr int kMaxDofs = 300;
constexpr int kMaxJoints = 1000;

std::string KnownSkeletons(Engine& engine, const std::string& database) {
  const auto known = engine.store().ListSkeletons(database, {"", kMaxListedSkeletons + 1});
  if (!known.ok() || known->empty()) return "it has none";
  if (known->size() > kMaxListedSkeletons) {
    return fmt::format("it has more than {}; ListSkeletons returns them", kMaxListedSkeletons);
  }
  std::string names;
  for (const storage::SkeletonRecord& record : *known) {
    names += (names.empty() ? "it has " : ", ") + record.id;
  }
  return names;
}

absl::StatusOr<PlanBody> StoredBody(const std::string& id, Engine& engine,
                                    const std::string& database) {
  auto skeleton = engine.skeletons().Get(database, id);
  if (absl::IsNotFound(skeleton.status())) {
    return core::WithReason("SKELETON_NOT_FOUND",
                            FieldViolation("skeleton", "database '{}' has no skeleton '{}': {}",
                                           database, id, KnownSkeletons(engine, database)));
  }
  if (!skeleton.ok()) return skeleton.status();
  return PlanBody{.skeleton = *std::move(skeleton), .skeleton_id = id};
}

absl::StatusOr<PlanBody> RobotBody(const core::SourceFile& urdf) {
  if (urdf.name.empty()) return FieldViolation("robot.file_name", "is missing");
  auto read = core::ReadUrdf(urdf);
  if (!read.ok()) return AtField("robot.urdf", read.status());
  return PlanBody{
      .skeleton = std::make_shared<const core::Skeleton>(std::move(read->skeleton)),
      .is_robot = true,
      .mimics = std::move(read->mimics),
      .dynamics = std::make_shared<const core::RobotDynamics>(std::move(read->dynamics)),
      .visuals = std::move(read->visuals)};
}

absl::StatusOr<PlanBody> BodyOfClip(const std::string& clip, Engine& engine,
                                    const std::string& database) {
  const auto record = engine.store().GetClip(database, clip);
  // Deleted, but still in the model: its motion remains, but its skeleton may be deleted.
  if (absl::IsNotFound(record.status())) return PlanBody{};
  if (!record.ok()) return record.status();
  if (record->skeleton_id.empty()) return PlanBody{};
  MOTIONDB_ASSIGN_OR_RETURN(auto skeleton, engine.skeletons().Get(database, record->skeleton_id));
  return PlanBody{.skeleton = std::move(skeleton), .skeleton_id = record->skeleton_id};
}

// Returns the record of a clip with the skeleton; nothing if there is none.
absl::StatusOr<std::optional<storage::ClipRecord>> FindClipOf(storage::MotionStore& store,
                                                              const std::string& database,
                                                              const std::string& skeleton_id) {
  constexpr int kPage = 1000;
  for (storage::Page page{"", kPage};;) {
    MOTIONDB_ASSIGN_OR_RETURN(const auto clips, store.ListClips(database, page));
    for (const storage::ClipRecord& clip : clips) {
      if (clip.skeleton_id == skeleton_id) return clip;
    }
    if (std::ssize(clips) < kPage) return std::nullopt;
    page.after = clips.back().id;
  }
}

// Returns the motion of a clip with the body's skeleton, or the skeleton at rest.
absl::StatusOr<core::Motion> MotionOf(const Query& query, const PlanBody& body) {
  storage::MotionStore& store = query.engine().store();
  const std::string& database = query.database()->name();
  const core::Motion rest =
      core::JointMotion{body.skeleton, 1, core::JointMatrix::Zero(1, body.skeleton->dof_count())};
  if (body.skeleton_id.empty()) return rest;
  MOTIONDB_ASSIGN_OR_RETURN(const auto clip, FindClipOf(store, database, body.skeleton_id));
  if (!clip) return rest;
  MOTIONDB_ASSIGN_OR_RETURN(const auto source, store.ReadClipSource(database, clip->id));
  const core::SourceFile file{clip->file_name, source.file_bytes};
  const auto skeleton = SkeletonFile(*clip, source.skeleton_bytes);
  MOTIONDB_ASSIGN_OR_RETURN(auto read,
                            ReadSource(clip->format, file, skeleton, clip->given, query.terms()));
  return std::move(read.motion);
}

// Completes a stored body that is a robot: the URDF of a clip with this skeleton has what the
// stored skeleton lacks.
absl::Status AddRobot(const Query& query, PlanBody& body) {
  if (body.is_robot || body.skeleton == nullptr || !core::IsRobot(*body.skeleton)) {
    return absl::OkStatus();
  }
  storage::MotionStore& store = query.engine().store();
  const std::string& database = query.database()->name();
  MOTIONDB_ASSIGN_OR_RETURN(const auto clip, FindClipOf(store, database, body.skeleton_id));
  if (!clip || clip->format != core::FileFormat::kCsv) return absl::OkStatus();
  MOTIONDB_ASSIGN_OR_RETURN(const auto source, store.ReadClipSource(database, clip->id));
  MOTIONDB_ASSIGN_OR_RETURN(core::UrdfRobot robot,
                            core::ReadUrdf({clip->skeleton_file_name, source.skeleton_bytes}));
  if (robot.skeleton.dof_count() != body.skeleton->dof_count() ||
      robot.skeleton.joint_count() != body.skeleton->joint_count()) {
    return absl::OkStatus();
  }
  body.is_robot = true;
  body.mimics = std::move(robot.mimics);
  body.dynamics = std::make_shared<const core::RobotDynamics>(std::move(robot.dynamics));
  body.visuals = std::move(robot.visuals);
  return absl::OkStatus();
}

// Returns the scheme with the mapping that the clips of the body have. An automatic one depends on
// their motion.
absl::StatusOr<core::MarkerScheme> FitBody(const Query& query, const core::MarkerScheme& scheme,
                                           const PlanBody& body) {
  if (core::BindMapping(scheme, core::JointNames(*body.skeleton)).ok()) return scheme;
  MOTIONDB_ASSIGN_OR_RETURN(const core::Motion motion, MotionOf(query, body));
  return core::FitScheme(scheme, motion, core::FitFor::kClip);
}

}  // namespace

absl::StatusOr<PlanBody> FindBody(const Query& query, const PlanRequest& request,
                                  const std::string& start_clip, const core::MarkerScheme& scheme) {
  const std::string& database = query.database()->name();
  absl::StatusOr<PlanBody> body;
  if (const auto* const id = std::get_if<std::string>(&request.body)) {
    body = StoredBody(*id, query.engine(), database);
  } else if (const auto* const urdf = std::get_if<core::SourceFile>(&request.body)) {
    // The size of the request says nothing about a compressed file.
    if (core::PlainBytes(urdf->bytes, core::kMaxSkeletonBytes) > urdf->bytes.size()) {
      MOTIONDB_RETURN_IF_ERROR(query.terms().Reserve(
          core::MaxBytesToRead(core::FileFormat::kCsv, {.name = urdf->name, .bytes = ""}, *urdf)));
    }
    body = RobotBody(*urdf);
  } else {
    body = BodyOfClip(start_clip, query.engine(), database);
  }
  if (!body.ok()) return body;
  body->scheme = scheme;
  if (body->skeleton == nullptr) {
    if (!request.needs_joints()) return body;
    return core::WithReason(
        "NO_SKELETON",
        core::FailedPrecondition(
            "a plan on bare markers cannot be written as a motion file: give a skeleton of the "
            "database or a robot (motiondb plan {} --skeleton NAME|FILE.urdf), a format of points "
            "(TRC, C3D), or omit include_files",
            database));
  }
  const std::string_view field = body->is_robot ? "robot.urdf" : "skeleton";
  if (body->skeleton->dof_count() > kMaxDofs || body->skeleton->joint_count() > kMaxJoints) {
    return FieldViolation(
        field, "expected at most {} joints of {} degrees of freedom in all, got {} of {}",
        kMaxJoints, kMaxDofs, body->skeleton->joint_count(), body->skeleton->dof_count());
  }
  MOTIONDB_RETURN_IF_ERROR(AddRobot(query, *body));
  auto fitted = FitBody(query, scheme, *body);
  if (!fitted.ok()) return AtField(field, fitted.status());
  body->scheme = *std::move(fitted);
  const absl::Status fits = core::MarkerKinematics::Create(body->scheme, body->skeleton).status();
  if (!fits.ok()) return AtField(field, fits);
  return body;
}

}  // namespace motiondb::server
