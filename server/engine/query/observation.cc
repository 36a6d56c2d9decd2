#include "server/engine/query/observation.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <set>

#include "core/format/plausibility.h"
#include "core/mapping/fit_scheme.h"
#include "core/motion/error.h"
#include "server/engine/database_caches.h"
#include "server/engine/live_database.h"
#include "server/engine/representation.h"
#include "server/engine/request_checks.h"
#include "server/engine/source_reader.h"

namespace motiondb::server {

using core::FieldViolation;

static_assert(std::endian::native == std::endian::little,
              "packed floats are copied without conversion");

absl::StatusOr<core::FrameMatrix> Unpack(std::string_view field, std::string_view name,
                                         const PackedFrames& packed, int columns) {
  if (packed.frame_count < 1) {
    return FieldViolation(fmt::format("{}.frame_count", field), "expected at least 1, got {}",
                          packed.frame_count);
  }
  const std::int64_t expected = std::int64_t{4} * packed.frame_count * columns;
  if (std::ssize(packed.values) != expected) {
    return FieldViolation(fmt::format("{}.{}", field, name),
                          "expected {} bytes, {} frames of {} float32, got {}", expected,
                          packed.frame_count, columns, packed.values.size());
  }
  core::FrameMatrix matrix(packed.frame_count, columns);
  std::memcpy(matrix.data(), packed.values.data(), packed.values.size());
  return matrix;
}

absl::Status CheckFinite(std::string_view field, const core::FrameMatrix& frames) {
  for (Eigen::Index frame = 0; frame < frames.rows(); ++frame) {
    if (!frames.row(frame).allFinite()) {
      return FieldViolation(field, "frame {} has a value that is not finite", frame);
    }
  }
  return absl::OkStatus();
}

absl::Status CheckMarkers(std::string_view field, const std::vector<std::string>& names,
                          const core::FrameMatrix& positions) {
  for (Eigen::Index frame = 0; frame < positions.rows(); ++frame) {
    for (std::size_t marker = 0; marker < names.size(); ++marker) {
      const auto position = positions.row(frame).segment<3>(static_cast<Eigen::Index>(3 * marker));
      if (position.allFinite() || position.array().isNaN().all()) continue;
      return FieldViolation(field,
                            "frame {}, marker '{}': expected three finite numbers, or three NaN "
                            "for a missing marker",
                            frame, names[marker]);
    }
  }
  return absl::OkStatus();
}

absl::Status CheckUnique(std::string_view field, const std::vector<std::string>& names) {
  std::set<std::string_view> seen;
  for (const std::string& name : names) {
    if (name.empty()) return FieldViolation(field, "a marker name is empty");
    if (!seen.insert(name).second) return FieldViolation(field, "duplicate marker name '{}'", name);
  }
  return absl::OkStatus();
}

namespace {

std::string SubField(const Observation& observation, std::string_view name) {
  return fmt::format("{}.{}", observation.field, name);
}

absl::Status CheckPositive(const Observation& observation, std::string_view name, double value) {
  if (std::isfinite(value) && value > 0) return absl::OkStatus();
  return FieldViolation(SubField(observation, name), "expected more than 0, got {}", value);
}

struct ReadObservation {
  core::Motion motion;
  std::optional<core::SourceReport> checked_report;  // of a file whose body size is to be checked
};

// Returns INVALID_ARGUMENT if many joints rotate by more than a turn in most frames, as numbers in
// degrees do.
absl::Status CheckRadians(const std::string& field, const core::Skeleton& skeleton,
                          const core::FrameMatrix& angles) {
  constexpr double kTurn = 2 * std::numbers::pi;
  int rotations = 0;
  int large = 0;
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    const core::Joint& joint = skeleton.joints()[j];
    for (std::size_t k = 0; k < joint.dofs.size(); ++k) {
      if (joint.dofs[k].kind != core::Dof::Kind::kRotation) continue;
      const auto column = angles.col(skeleton.first_dof(j) + static_cast<int>(k)).array().abs();
      ++rotations;
      large += 2 * (column > kTurn).count() > angles.rows();
    }
  }
  if (large < 3 || 5 * large < rotations) return absl::OkStatus();
  return FieldViolation(field,
                        "expected radians; {} of {} rotations are beyond a full turn in most "
                        "frames, as degrees are; if they are right, set force",
                        large, rotations);
}

// Reads an observation for one database.
class Reader {
 public:
  Reader(const Observation& observation, const LiveDatabase& database, SkeletonCache& skeletons,
         const WorkOptions& terms, const core::MarkerSet& set)
      : observation_(observation),
        database_(database),
        skeletons_(skeletons),
        terms_(terms),
        set_(set) {}

  absl::StatusOr<ReadObservation> Read() const {
    MOTIONDB_RETURN_IF_ERROR(CheckStated());
    if (observation_.leg_length_m) {
      MOTIONDB_RETURN_IF_ERROR(
          CheckPositive(observation_, "leg_length_m", *observation_.leg_length_m));
    }
    return std::visit([this](const auto& motion) { return ReadForm(motion); }, observation_.motion);
  }

 private:
  // Checks what the caller states about a file, or about the body of markers.
  absl::Status CheckStated() const {
    if (const auto* const file = std::get_if<ObservedFile>(&observation_.motion)) {
      MOTIONDB_RETURN_IF_ERROR(CheckSkeletonFile(observation_.field, file->format,
                                                 file->skeleton ? file->skeleton->name : ""));
      return CheckConventions(observation_.field, file->conventions, observation_.leg_length_m,
                              file->force);
    }
    constexpr double kMaxLeg_m = 3;  // of persons and robots
    if (!observation_.leg_length_m || !(*observation_.leg_length_m > kMaxLeg_m)) {
      return absl::OkStatus();
    }
    return FieldViolation(SubField(observation_, "leg_length_m"),
                          "expected at most {} metres, got {}", kMaxLeg_m,
                          *observation_.leg_length_m);
  }

  absl::StatusOr<ReadObservation> ReadForm(const ObservedFile& file) const {
    auto read = ReadSource(file.format, file.file, file.skeleton, file.conventions, terms_);
    if (!read.ok()) return core::AtField(SubField(observation_, "data"), read.status());
    ReadObservation result{std::move(read->motion), std::nullopt};
    if (!file.force) result.checked_report = std::move(read->report);
    return result;
  }

  absl::StatusOr<ReadObservation> ReadForm(const ObservedMarkers& markers) const {
    MOTIONDB_RETURN_IF_ERROR(CheckPositive(observation_, "frame_rate_hz", markers.frame_rate_hz));
    // Bytes of a copied name and its set entry.
    constexpr std::int64_t kName = 160;
    std::int64_t bytes = std::ssize(markers.positions.values);
    for (const std::string_view name : markers.names) bytes += kName + std::ssize(name);
    MOTIONDB_RETURN_IF_ERROR(terms_.Reserve(bytes));
    core::MarkerMotion motion;
    motion.names.assign(markers.names.begin(), markers.names.end());
    if (motion.names.empty()) motion.names = set_.markers;
    MOTIONDB_RETURN_IF_ERROR(CheckUnique(SubField(observation_, "marker_names"), motion.names));
    motion.frame_rate_hz = markers.frame_rate_hz;
    const int columns = 3 * static_cast<int>(motion.names.size());
    MOTIONDB_ASSIGN_OR_RETURN(motion.positions_m,
                              Unpack(observation_.field, "positions", markers.positions, columns));
    MOTIONDB_RETURN_IF_ERROR(
        CheckMarkers(SubField(observation_, "positions"), motion.names, motion.positions_m));
    return ReadObservation{std::move(motion), std::nullopt};
  }

  absl::StatusOr<ReadObservation> ReadForm(const ObservedJoints& joints) const {
    MOTIONDB_RETURN_IF_ERROR(CheckPositive(observation_, "frame_rate_hz", joints.frame_rate_hz));
    // As float and as double.
    MOTIONDB_RETURN_IF_ERROR(terms_.Reserve(3 * std::ssize(joints.angles.values)));
    core::JointMotion motion;
    MOTIONDB_ASSIGN_OR_RETURN(motion.skeleton, skeletons_.Get(database_.name(), joints.skeleton));
    motion.frame_rate_hz = joints.frame_rate_hz;
    MOTIONDB_ASSIGN_OR_RETURN(
        const core::FrameMatrix angles,
        Unpack(observation_.field, "angles", joints.angles, motion.skeleton->dof_count()));
    MOTIONDB_RETURN_IF_ERROR(CheckFinite(SubField(observation_, "angles"), angles));
    if (!joints.force) {
      MOTIONDB_RETURN_IF_ERROR(
          CheckRadians(SubField(observation_, "angles"), *motion.skeleton, angles));
    }
    motion.angles = angles.cast<double>();
    return ReadObservation{std::move(motion), std::nullopt};
  }

  const Observation& observation_;
  const LiveDatabase& database_;
  SkeletonCache& skeletons_;
  const WorkOptions& terms_;
  const core::MarkerSet& set_;
};

}  // namespace

absl::StatusOr<core::StateSequence> StatesOf(const Observation& observation,
                                             const LiveDatabase& database, SkeletonCache& skeletons,
                                             int max_frames, const WorkOptions& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto scheme, database.scheme());
  MOTIONDB_ASSIGN_OR_RETURN(const ReadObservation read,
                            Reader(observation, database, skeletons, terms, scheme->set).Read());
  const RepresentationLimits limits{database.settings().frame_rate_hz, max_frames, terms};
  auto states =
      RepresentWithin(limits, *scheme, read.motion, core::kObservation, observation.leg_length_m);
  if (!states.ok()) return core::AtField(observation.field, states.status());
  if (read.checked_report) {
    MOTIONDB_RETURN_IF_ERROR(core::AtField(
        observation.field, core::CheckBodySize(scheme->set, *states, *read.checked_report)));
  }
  return states;
}

absl::StatusOr<core::MarkerMotion> MarkersOf(const Observation& observation,
                                             const LiveDatabase& database, SkeletonCache& skeletons,
                                             int max_frames, const WorkOptions& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto scheme, database.scheme());
  MOTIONDB_ASSIGN_OR_RETURN(const ReadObservation read,
                            Reader(observation, database, skeletons, terms, scheme->set).Read());
  const core::Motion& motion = read.motion;
  const RepresentationLimits limits{FrameRate(motion), max_frames, terms};
  MOTIONDB_RETURN_IF_ERROR(
      core::AtField(observation.field, CheckSize(limits, scheme->set.marker_count(), motion)));
  const auto fitted = core::FitScheme(*scheme, motion, core::FitFor::kQuery);
  if (!fitted.ok()) return core::AtField(observation.field, fitted.status());
  auto markers = core::ApplyScheme(*fitted, motion, observation.leg_length_m, terms.cancelled);
  if (!markers.ok()) return core::AtField(observation.field, markers.status());
  if (read.checked_report) {
    MOTIONDB_RETURN_IF_ERROR(core::AtField(
        observation.field, core::CheckBodySize(scheme->set, *markers, *read.checked_report)));
  }
  return markers;
}

}  // namespace motiondb::server
