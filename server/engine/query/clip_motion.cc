#include "server/engine/query/clip_motion.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <variant>

#include "core/format/urdf_reader.h"
#include "core/motion/error.h"
#include "core/motion/marker_set.h"
#include "core/motion/states.h"
#include "core/view/clip_picture.h"
#include "server/engine/engine.h"
#include "server/engine/ingest.h"
#include "server/engine/live_database.h"
#include "server/engine/representation.h"
#include "server/engine/snapshot.h"
#include "server/engine/source_reader.h"

namespace motiondb::server {
namespace {

using SchemePointer = std::shared_ptr<const core::MarkerScheme>;

// Maximum frames x markers of light work: 30,000 frames of 34 markers are read in about 0.1 s.
constexpr std::int64_t kMaxLightMarkers = 1 << 20;

absl::StatusOr<SchemePointer> SchemeOf(const LiveDatabase& database) {
  MOTIONDB_ASSIGN_OR_RETURN(SchemePointer scheme, database.scheme());
  if (scheme != nullptr) return scheme;
  return core::FailedPrecondition(
      "database '{}' has no marker set yet: its first clip will name the markers", database.name());
}

// Returns the requested frames of a clip.
absl::StatusOr<FrameRange> RangeIn(const FrameRange& requested, int clip_frames) {
  if (requested.first < 0 || requested.first >= clip_frames) {
    return core::FieldViolation("first_frame",
                                "expected 0 to {}, the last frame of the clip, got {}",
                                clip_frames - 1, requested.first);
  }
  if (requested.count < 0) {
    return core::FieldViolation("frame_count", "expected at least 0, got {}", requested.count);
  }
  if (requested.stride < 0) {
    return core::FieldViolation("stride", "expected at least 0, got {}", requested.stride);
  }
  const int stride = std::max(1, requested.stride);
  const int all = (clip_frames - 1 - requested.first) / stride + 1;
  return FrameRange{requested.first, requested.count == 0 ? all : std::min(all, requested.count),
                    stride};
}

// Returns the states of a clip within the limits of the work.
absl::StatusOr<core::StateSequence> StatesOfClip(Engine& engine, const storage::ClipRecord& clip,
                                                 const core::MarkerSet& set,
                                                 const WorkOptions& terms) {
  const std::int64_t markers = std::int64_t{clip.frame_count} * set.marker_count();
  if (markers > kMaxLightMarkers && terms.allowed == AllowedWork::kLightWork) return HeavyWork();
  MOTIONDB_RETURN_IF_ERROR(
      terms.Reserve(BytesOfStates(clip.frame_count, set.marker_count()) + 12 * markers));
  return engine.store().ReadClipStates(clip.database, clip.id);
}

// Reads the figure and the motion of one clip.
class ClipReader {
 public:
  static absl::StatusOr<ClipReader> Open(Engine& engine, const storage::ClipRecord& clip,
                                         const WorkOptions& terms) {
    ClipReader reader(engine, clip, terms);
    MOTIONDB_ASSIGN_OR_RETURN(reader.database_, engine.FindDatabase(clip.database));
    MOTIONDB_ASSIGN_OR_RETURN(reader.scheme_, SchemeOf(*reader.database_));
    if (!clip.skeleton_id.empty()) {
      MOTIONDB_ASSIGN_OR_RETURN(reader.skeleton_,
                                engine.skeletons().Get(clip.database, clip.skeleton_id));
    }
    MOTIONDB_ASSIGN_OR_RETURN(const SnapshotPointer snapshot,
                              engine.ModelIfAny(*reader.database_, terms));
    if (snapshot != nullptr) {
      reader.of_model_ = snapshot->view->Figure(snapshot->model);
    }
    return reader;
  }

  absl::StatusOr<Figure> ReadFigure() const {
    if (HasBones()) return FigureWith(nullptr);
    MOTIONDB_ASSIGN_OR_RETURN(const core::StateSequence states,
                              StatesOfClip(engine_, clip_, scheme_->set, terms_));
    return FigureWith(&states);
  }

  absl::StatusOr<ClipMotion> ReadMotion(bool joints) const {
    if (joints && skeleton_ != nullptr && terms_.allowed == AllowedWork::kLightWork) {
      return HeavyWork();
    }
    MOTIONDB_ASSIGN_OR_RETURN(const core::StateSequence states,
                              StatesOfClip(engine_, clip_, scheme_->set, terms_));
    ClipMotion motion{.figure = FigureWith(&states),
                      .frame_rate_hz = states.frame_rate_hz,
                      .markers_m = core::WorldPositions(states)};
    const core::Feet feet =
        of_model_ == nullptr ? core::FindFeet(scheme_->set, states.states) : of_model_->feet;
    motion.contacts = core::StandingFeet(scheme_->set, feet, motion.markers_m, states.frame_rate_hz,
                                         states.leg_length_m);
    if (joints && skeleton_ != nullptr) {
      MOTIONDB_RETURN_IF_ERROR(AddJoints(states, motion));
    }
    return motion;
  }

 private:
  ClipReader(Engine& engine, const storage::ClipRecord& clip, const WorkOptions& terms)
      : engine_(engine), clip_(clip), terms_(terms) {}

  // Whether the bones need no motion of the clip.
  bool HasBones() const {
    return of_model_ != nullptr ||
           (skeleton_ != nullptr && !core::MarkerBonesOf(scheme_->set, *skeleton_).empty());
  }

  Figure FigureWith(const core::StateSequence* states) const {
    Figure figure{.marker_names = scheme_->set.markers};
    if (skeleton_ != nullptr) {
      figure.joint_names = core::JointNames(*skeleton_);
      figure.joint_bones = core::JointBones(*skeleton_);
      figure.marker_bones = core::MarkerBonesOf(scheme_->set, *skeleton_);
    }
    if (!figure.marker_bones.empty()) return figure;
    figure.marker_bones =
        of_model_ != nullptr ? of_model_->bones : core::MarkerBones(scheme_->set, *states);
    return figure;
  }

  // Derives the states again, to know which frames of the file they are.
  absl::Status AddJoints(const core::StateSequence& stored, ClipMotion& to) const {
    MOTIONDB_ASSIGN_OR_RETURN(const storage::ClipSource source,
                              engine_.store().ReadClipSource(clip_.database, clip_.id));
    MOTIONDB_ASSIGN_OR_RETURN(
        const core::MotionFile file,
        ReadSource(clip_.format, {clip_.file_name, source.file_bytes},
                   SkeletonFile(clip_, source.skeleton_bytes), clip_.given, terms_));
    const auto* const motion = std::get_if<core::JointMotion>(&file.motion);
    if (motion == nullptr || motion->skeleton->joint_count() != skeleton_->joint_count()) {
      return Changed();
    }
    core::SourcePart part;
    const core::GlitchPolicy policy = database_->settings().glitches;
    auto derived = Derive(file.motion, policy, part);
    // Clips that are older than the policy keep their glitches (reprocess.h).
    if (absl::IsInvalidArgument(derived.status())) {
      derived = Derive(file.motion, core::GlitchPolicy::kKeep, part);
    }
    if (absl::IsInvalidArgument(derived.status())) return Changed();
    if (!derived.ok()) return derived.status();
    MOTIONDB_ASSIGN_OR_RETURN(to.joints_m,
                              core::RecordedJoints(*motion, part, stored.frame_rate_hz));
    if (to.joints_m.rows() != stored.states.rows()) return Changed();
    if (clip_.format != core::FileFormat::kCsv) return absl::OkStatus();
    MOTIONDB_ASSIGN_OR_RETURN(core::UrdfRobot robot,
                              core::ReadUrdf({clip_.skeleton_file_name, source.skeleton_bytes}));
    if (robot.visuals.empty()) return absl::OkStatus();
    to.figure.joint_visuals = std::move(robot.visuals);
    MOTIONDB_ASSIGN_OR_RETURN(to.joint_rotations,
                              core::RecordedRotations(*motion, part, stored.frame_rate_hz));
    return absl::OkStatus();
  }

  absl::StatusOr<core::StateSequence> Derive(const core::Motion& motion, core::GlitchPolicy policy,
                                             core::SourcePart& part) const {
    // No frame limit: the clip is already stored.
    const RepresentationLimits limits{database_->settings().frame_rate_hz,
                                      std::numeric_limits<int>::max(), terms_};
    return RepresentWithin(limits, *scheme_, motion, policy, clip_.given_leg_length_m, nullptr,
                           &part);
  }

  absl::Status Changed() const {
    return core::FailedPrecondition(
        "clip '{}': its file no longer gives the stored frames, so its joints are unknown; "
        "reprocess the database",
        clip_.id);
  }

  Engine& engine_;
  const storage::ClipRecord& clip_;
  const WorkOptions& terms_;
  std::shared_ptr<LiveDatabase> database_;
  SchemePointer scheme_;
  std::shared_ptr<const core::Skeleton> skeleton_;  // null: bare markers
  std::shared_ptr<const ModelFigure> of_model_;     // null: there is no model
};

}  // namespace

absl::StatusOr<Figure> DatabaseFigure(Engine& engine, const std::string& database,
                                      const WorkOptions& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto live, engine.FindDatabase(database));
  MOTIONDB_ASSIGN_OR_RETURN(const SchemePointer scheme, SchemeOf(*live));
  Figure figure{.marker_names = scheme->set.markers};
  MOTIONDB_ASSIGN_OR_RETURN(const auto skeletons, engine.store().ListSkeletons(database, {"", 1}));
  if (!skeletons.empty()) {
    figure.marker_bones = core::MarkerBonesOf(scheme->set, skeletons.front().skeleton);
  }
  MOTIONDB_ASSIGN_OR_RETURN(const SnapshotPointer snapshot, engine.ModelIfAny(*live, terms));
  if (figure.marker_bones.empty() && snapshot != nullptr) {
    figure.marker_bones = snapshot->view->Figure(snapshot->model)->bones;
  }
  return figure;
}

absl::StatusOr<Figure> ClipFigure(Engine& engine, const std::string& database,
                                  const std::string& clip, const WorkOptions& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto record, engine.store().GetClip(database, clip));
  MOTIONDB_ASSIGN_OR_RETURN(const ClipReader reader, ClipReader::Open(engine, record, terms));
  return reader.ReadFigure();
}

absl::StatusOr<ClipMotion> ReadClipMotion(Engine& engine, const std::string& database,
                                          const std::string& clip, const FrameRange& requested,
                                          bool joints, const WorkOptions& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto record, engine.store().GetClip(database, clip));
  MOTIONDB_RETURN_IF_ERROR(RangeIn(requested, record.frame_count).status());
  MOTIONDB_ASSIGN_OR_RETURN(const ClipReader reader, ClipReader::Open(engine, record, terms));
  MOTIONDB_ASSIGN_OR_RETURN(ClipMotion motion, reader.ReadMotion(joints));
  // The clip may have been replaced since.
  MOTIONDB_ASSIGN_OR_RETURN(motion.requested, RangeIn(requested, motion.frame_count()));
  return motion;
}

}  // namespace motiondb::server
