#include "server/translate/plan_body.h"

#include "core/kinematics/marker_kinematics.h"
#include "core/motion/error.h"
#include "motiondb/v1/plan.pb.h"
#include "server/translate/field_violation.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {
namespace {

constexpr int kShownSkeletons = 10;
// Of a body that plays: inverse kinematics squares and cubes what moves, and every frame has all.
constexpr int kMostDofs = 300;
constexpr int kMostJoints = 1000;

std::string KnownSkeletons(Engine& engine, const std::string& database) {
  const auto known = engine.store().ListSkeletons(database, {"", kShownSkeletons + 1});
  if (!known.ok() || known->empty()) return "it has none";
  if (known->size() > kShownSkeletons) {
    return fmt::format("it has more than {}, which ListSkeletons tells", kShownSkeletons);
  }
  std::string names;
  for (const storage::SkeletonRecord& record : *known) {
    names += (names.empty() ? "it has " : ", ") + record.id;
  }
  return names;
}

absl::StatusOr<PlanBody> StoredBody(const std::string& name, Engine& engine,
                                    const std::string& database) {
  MOTIONDB_ASSIGN_OR_RETURN(const MemberId id, ParseSkeletonName("skeleton", name));
  if (id.database != database) {
    return FieldViolation("skeleton", "expected a skeleton of databases/{}, got '{}'", database,
                          name);
  }
  auto skeleton = engine.skeletons().Get(database, id.id);
  if (absl::IsNotFound(skeleton.status())) {
    return FieldViolation("skeleton", "database '{}' has no skeleton '{}': {}", database, id.id,
                          KnownSkeletons(engine, database));
  }
  if (!skeleton.ok()) return skeleton.status();
  return PlanBody{.skeleton = *std::move(skeleton)};
}

absl::StatusOr<PlanBody> RobotBody(const v1::RobotDescription& robot) {
  if (robot.file_name().empty()) return FieldViolation("robot.file_name", "is missing");
  auto read = core::ReadUrdf({robot.file_name(), robot.urdf()});
  if (!read.ok()) return AtField("robot.urdf", read.status());
  return PlanBody{.skeleton = std::make_shared<const core::Skeleton>(std::move(read->skeleton)),
                  .is_robot = true,
                  .mimics = std::move(read->mimics)};
}

absl::StatusOr<PlanBody> BodyOfClip(const std::string& clip, Engine& engine,
                                    const std::string& database) {
  const auto record = engine.store().GetClip(database, clip);
  // Deleted, but still in the model: its motion is left, and perhaps nothing that it belongs to.
  if (absl::IsNotFound(record.status())) return PlanBody{};
  if (!record.ok()) return record.status();
  if (record->skeleton_id.empty()) return PlanBody{};
  MOTIONDB_ASSIGN_OR_RETURN(auto skeleton, engine.skeletons().Get(database, record->skeleton_id));
  return PlanBody{.skeleton = std::move(skeleton)};
}

}  // namespace

absl::StatusOr<PlanBody> BodyFrom(const v1::PlanRequest& request, const std::string& start_clip,
                                  const core::MarkerScheme& scheme, Engine& engine,
                                  const LiveDatabase& database) {
  absl::StatusOr<PlanBody> body;
  switch (request.body_case()) {
    case v1::PlanRequest::kSkeleton:
      body = StoredBody(request.skeleton(), engine, database.name());
      break;
    case v1::PlanRequest::kRobot:
      body = RobotBody(request.robot());
      break;
    case v1::PlanRequest::BODY_NOT_SET:
      body = BodyOfClip(start_clip, engine, database.name());
      break;
  }
  if (!body.ok()) return body;
  if (body->skeleton == nullptr) {
    if (!request.include_files()) return body;
    return core::FailedPrecondition(
        "a plan on bare markers fits no motion file: name a skeleton of the database or send a "
        "robot (motiondb plan {} --skeleton NAME|FILE.urdf), or leave include_files out",
        database.name());
  }
  const std::string_view field = body->is_robot ? "robot.urdf" : "skeleton";
  if (body->skeleton->dof_count() > kMostDofs || body->skeleton->joint_count() > kMostJoints) {
    return FieldViolation(
        field, "expected at most {} joints of {} degrees of freedom in all, got {} of {}",
        kMostJoints, kMostDofs, body->skeleton->joint_count(), body->skeleton->dof_count());
  }
  const absl::Status fits = core::MarkerKinematics::Create(scheme, body->skeleton).status();
  if (!fits.ok()) return AtField(field, fits);
  return body;
}

}  // namespace motiondb::server
