// The observation of a query as the caller sent it, and its conversion to states or to the
// database's markers.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "core/motion/matrix.h"
#include "core/motion/motion.h"
#include "core/motion/states.h"
#include "server/engine/work/work_options.h"

namespace motiondb::server {

class LiveDatabase;
class SkeletonCache;

// Frames as packed in a request. The functions return INVALID_ARGUMENT, naming the field and, if
// possible, the frame. Sizes are checked before memory is allocated.

struct PackedFrames {
  int frame_count = 0;
  std::string_view values;  // float32, little-endian, row-major
};

// Returns the matrix (frames x columns) in field `name` of the message `field`.
absl::StatusOr<core::FrameMatrix> Unpack(std::string_view field, std::string_view name,
                                         const PackedFrames& packed, int columns);

absl::Status CheckFinite(std::string_view field, const core::FrameMatrix& frames);
// Each marker (frames x 3 names) must be finite, or NaN in all three coordinates (missing).
absl::Status CheckMarkers(std::string_view field, const std::vector<std::string>& names,
                          const core::FrameMatrix& positions_m);
// Marker names must be unique and not empty.
absl::Status CheckUnique(std::string_view field, const std::vector<std::string>& names);

struct ObservedFile {
  core::FileFormat format = core::FileFormat::kBvh;
  core::SourceFile file;
  std::optional<core::SourceFile> skeleton;  // the ASF of an AMC
  core::ReadOptions conventions;
  bool force = false;  // accept an implausible body size
};

struct ObservedMarkers {
  std::vector<std::string_view> names;  // empty: the database's markers
  double frame_rate_hz = 0;
  PackedFrames positions;  // frames x 3 names, m, world, z up; a missing marker is NaN in all three
};

struct ObservedJoints {
  std::string skeleton;  // skeleton id in the database
  double frame_rate_hz = 0;
  PackedFrames angles;  // frames x degrees of freedom, rad and m
  bool force = false;   // accept angles that look like degrees
};

// References the caller's data, which must outlive it.
struct Observation {
  std::string field;  // path in the request, such as "observation.file"; used in errors
  std::variant<ObservedFile, ObservedMarkers, ObservedJoints> motion;
  std::optional<double> leg_length_m;
};

// Returns states at the database's frame rate, not scaled; NaN if a marker is missing. Codes:
// INVALID_ARGUMENT, NOT_FOUND (skeleton), RESOURCE_EXHAUSTED, CANCELLED; see also IsHeavyWork.
absl::StatusOr<core::StateSequence> StatesOf(const Observation& observation,
                                             const LiveDatabase& database, SkeletonCache& skeletons,
                                             int max_frames, const WorkOptions& terms);

// Returns the database's markers at the observation's frame rate. Codes as above.
absl::StatusOr<core::MarkerMotion> MarkersOf(const Observation& observation,
                                             const LiveDatabase& database, SkeletonCache& skeletons,
                                             int max_frames, const WorkOptions& terms);

}  // namespace motiondb::server
