// A store with one large database in it, as a server would make it: clips added, then a full
// rebuild. Functions keep no state.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/tree/parallel.h"
#include "storage/motion_store.h"
#include "tests/bench/varied_motion.h"

namespace motiondb::tests {

inline constexpr char kLargeDatabase[] = "large";

// A stage of a rebuild: its name, its wall time, the processor time of all threads and the most
// memory that the process had held when it ended.
struct BuildStage {
  std::string name;
  double seconds = 0;
  double processor_seconds = 0;
  double peak_mb = 0;
};

// Makes the store at `path`, where nothing is, with these clips and no model. Their motion files
// are a line each, so the store holds little that a start does not read.
absl::Status MakeClipStore(const std::string& path, double frame_rate_hz,
                           std::vector<core::BuildInput> clips);

// Builds and stores the model of the store's clips; returns the stages. The last stage's peak is
// that of the whole build.
absl::StatusOr<std::vector<BuildStage>> RebuildStore(const std::string& path,
                                                     const core::ParallelFor& parallel);

// Both, of varied clips.
absl::StatusOr<std::vector<BuildStage>> MakeLargeStore(const std::string& path,
                                                       const VariedSize& size, std::uint64_t seed,
                                                       const core::ParallelFor& parallel);

// Adds clips to the large database of a store, with a line for a file each.
absl::Status AddClips(storage::MotionStore& store, std::vector<core::BuildInput> inputs);

// Megabytes (10^6 bytes) of this process by a field of /proc/self/status: "VmRSS", "VmHWM".
double ProcessMegabytes(const std::string& field);

}  // namespace motiondb::tests
