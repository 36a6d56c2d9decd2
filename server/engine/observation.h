// Motion that a query is about, as the caller sent it, and what it becomes: states as the models of
// a database know them, or the database's markers. Safe to call from any thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "core/motion/motion.h"
#include "core/motion/states.h"
#include "server/engine/packed_frames.h"
#include "server/engine/representation.h"
#include "server/engine/skeleton_cache.h"

namespace motiondb::server {

class LiveDatabase;

struct ObservedFile {
  core::FileFormat format = core::FileFormat::kBvh;
  core::SourceFile file;
  std::optional<core::SourceFile> skeleton;  // the ASF of an AMC
  core::ReadOptions conventions;
};

struct ObservedMarkers {
  std::vector<std::string_view> names;  // empty: the database's markers
  double frame_rate_hz = 0;
  PackedFrames positions;  // frames x 3 names, m, world, z up; a missing marker is NaN in all three
};

struct ObservedJoints {
  std::string skeleton;  // id of a skeleton of the database
  double frame_rate_hz = 0;
  PackedFrames angles;  // frames x degrees of freedom, rad and m
};

// Refers to what the caller sent, which must outlive it.
struct Observation {
  std::string field;  // where the request has it, such as "observation.file": errors name it
  std::variant<ObservedFile, ObservedMarkers, ObservedJoints> motion;
  std::optional<double> leg_length_m;
};

// States at the database's frame rate, not scaled; NaN where a marker was missing. Codes:
// INVALID_ARGUMENT, NOT_FOUND (a skeleton), RESOURCE_EXHAUSTED, CANCELLED; and IsHeavyWork.
absl::StatusOr<core::StateSequence> StatesOf(const Observation& observation,
                                             const LiveDatabase& database, SkeletonCache& skeletons,
                                             int max_frames, const WorkTerms& terms);

// The database's markers, at the observation's own frame rate. Codes as above.
absl::StatusOr<core::MarkerMotion> MarkersOf(const Observation& observation,
                                             const LiveDatabase& database, SkeletonCache& skeletons,
                                             int max_frames, const WorkTerms& terms);

}  // namespace motiondb::server
