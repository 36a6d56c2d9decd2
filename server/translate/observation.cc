#include "server/translate/observation.h"

#include "core/motion/error.h"
#include "motiondb/v1/query.pb.h"
#include "server/translate/field_violation.h"
#include "server/translate/file_format.h"
#include "server/translate/frames.h"
#include "server/translate/numbers.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {
namespace {

struct ObservedMotion {
  core::Motion motion;
  std::optional<double> leg_length_m;
  std::string form_field;
};

std::string Below(std::string_view field, std::string_view name) {
  return fmt::format("{}.{}", field, name);
}

absl::StatusOr<ObservedMotion> MotionFrom(const std::string& field, const v1::FileObservation& file,
                                          const WorkTerms& terms) {
  if (file.file_name().empty()) return FieldViolation(Below(field, "file_name"), "is missing");
  MOTIONDB_ASSIGN_OR_RETURN(const core::FileFormat format,
                            FileFormatFrom(field, file.format(), file.file_name()));
  MOTIONDB_RETURN_IF_ERROR(CheckSkeletonFile(field, format, file.skeleton_file_name()));
  MOTIONDB_ASSIGN_OR_RETURN(const Conventions conventions,
                            ConventionsFrom(field, file.conventions()));
  std::optional<core::SourceFile> skeleton;
  if (!file.skeleton_file_name().empty()) {
    skeleton = core::SourceFile{file.skeleton_file_name(), file.skeleton_data()};
  }
  MOTIONDB_RETURN_IF_ERROR(
      terms.Reserve(core::MostBytesToRead(format, {file.file_name(), file.data()}, skeleton)));
  auto read =
      core::ReadMotionFile(format, {file.file_name(), file.data()}, skeleton, conventions.read);
  if (!read.ok()) return AtField(Below(field, "data"), read.status());
  return ObservedMotion{std::move(read->motion), conventions.leg_length_m, {}};
}

absl::StatusOr<ObservedMotion> MotionFrom(const std::string& field,
                                          const v1::MarkerObservation& markers,
                                          const core::MarkerSet& set, const WorkTerms& terms) {
  // Names are copied, and looked at in a set.
  constexpr std::int64_t kName = 160;
  MOTIONDB_RETURN_IF_ERROR(terms.Reserve(
      static_cast<std::int64_t>(markers.positions().size()) + kName * markers.marker_names_size() +
      static_cast<std::int64_t>(markers.marker_names().SpaceUsedExcludingSelfLong())));
  core::MarkerMotion motion;
  motion.names.assign(markers.marker_names().begin(), markers.marker_names().end());
  if (motion.names.empty()) motion.names = set.markers;
  MOTIONDB_RETURN_IF_ERROR(CheckUnique(Below(field, "marker_names"), motion.names));
  MOTIONDB_ASSIGN_OR_RETURN(motion.frame_rate_hz,
                            Positive(Below(field, "frame_rate_hz"), markers.frame_rate_hz()));
  const FrameShape shape{markers.frame_count(), 3 * static_cast<int>(motion.names.size())};
  MOTIONDB_ASSIGN_OR_RETURN(motion.positions_m,
                            FramesFrom(field, "positions", shape, markers.positions()));
  MOTIONDB_RETURN_IF_ERROR(
      CheckMarkers(Below(field, "positions"), motion.names, motion.positions_m));
  MOTIONDB_ASSIGN_OR_RETURN(const auto leg_length,
                            OptionalPositive(Below(field, "leg_length_m"), markers.leg_length_m()));
  return ObservedMotion{std::move(motion), leg_length, {}};
}

absl::StatusOr<ObservedMotion> MotionFrom(const std::string& field,
                                          const v1::JointObservation& joints,
                                          SkeletonCache& skeletons, const std::string& database,
                                          const WorkTerms& terms) {
  // As float, then as double.
  MOTIONDB_RETURN_IF_ERROR(terms.Reserve(3 * static_cast<std::int64_t>(joints.angles().size())));
  const std::string skeleton_field = Below(field, "skeleton");
  MOTIONDB_ASSIGN_OR_RETURN(const MemberId id,
                            ParseSkeletonName(skeleton_field, joints.skeleton()));
  if (id.database != database) {
    return FieldViolation(skeleton_field, "expected a skeleton of databases/{}, got '{}'", database,
                          joints.skeleton());
  }
  core::JointMotion motion;
  MOTIONDB_ASSIGN_OR_RETURN(motion.skeleton, skeletons.Get(database, id.id));
  MOTIONDB_ASSIGN_OR_RETURN(motion.frame_rate_hz,
                            Positive(Below(field, "frame_rate_hz"), joints.frame_rate_hz()));
  const FrameShape shape{joints.frame_count(), motion.skeleton->dof_count()};
  MOTIONDB_ASSIGN_OR_RETURN(const core::FrameMatrix angles,
                            FramesFrom(field, "angles", shape, joints.angles()));
  MOTIONDB_RETURN_IF_ERROR(CheckFinite(Below(field, "angles"), angles));
  motion.angles = angles.cast<double>();
  return ObservedMotion{std::move(motion), std::nullopt, {}};
}

absl::StatusOr<ObservedMotion> Read(std::string_view field, const v1::Observation& observation,
                                    Engine& engine, const LiveDatabase& database,
                                    const core::MarkerSet& set, const WorkTerms& terms) {
  std::string form_field;
  absl::StatusOr<ObservedMotion> observed;
  switch (observation.form_case()) {
    case v1::Observation::kFile:
      form_field = Below(field, "file");
      observed = MotionFrom(form_field, observation.file(), terms);
      break;
    case v1::Observation::kMarkers:
      form_field = Below(field, "markers");
      observed = MotionFrom(form_field, observation.markers(), set, terms);
      break;
    case v1::Observation::kJoints:
      form_field = Below(field, "joints");
      observed =
          MotionFrom(form_field, observation.joints(), engine.skeletons(), database.name(), terms);
      break;
    case v1::Observation::FORM_NOT_SET:
      return FieldViolation(field, "expected one of file, markers, joints");
  }
  if (observed.ok()) observed->form_field = std::move(form_field);
  return observed;
}

}  // namespace

absl::StatusOr<core::StateSequence> StatesFrom(std::string_view field,
                                               const v1::Observation& observation, Engine& engine,
                                               const LiveDatabase& database,
                                               const WorkTerms& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto scheme, database.scheme());
  MOTIONDB_ASSIGN_OR_RETURN(const ObservedMotion observed,
                            Read(field, observation, engine, database, scheme->set, terms));
  const RepresentationLimits limits{database.settings().frame_rate_hz, engine.options().max_frames,
                                    terms};
  auto states =
      RepresentWithin(limits, *scheme, observed.motion, core::Gaps::kKeep, observed.leg_length_m);
  if (!states.ok()) return AtField(observed.form_field, states.status());
  return states;
}

absl::StatusOr<core::MarkerMotion> MarkersFrom(std::string_view field,
                                               const v1::Observation& observation, Engine& engine,
                                               const LiveDatabase& database,
                                               const WorkTerms& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto scheme, database.scheme());
  MOTIONDB_ASSIGN_OR_RETURN(const ObservedMotion observed,
                            Read(field, observation, engine, database, scheme->set, terms));
  const RepresentationLimits limits{FrameRate(observed.motion), engine.options().max_frames, terms};
  MOTIONDB_RETURN_IF_ERROR(
      AtField(observed.form_field, CheckSize(limits, scheme->set.marker_count(), observed.motion)));
  auto markers =
      core::ApplyScheme(*scheme, observed.motion, observed.leg_length_m, terms.cancelled);
  if (!markers.ok()) return AtField(observed.form_field, markers.status());
  return markers;
}

}  // namespace motiondb::server
