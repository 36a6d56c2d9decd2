// A store with one large database, created as by a server: clips are added, then a full rebuild.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "storage/motion_store.h"
#include "tests/bench/varied_motion.h"

namespace motiondb::tests {

inline constexpr char kLargeDatabase[] = "large";

// A stage of a rebuild: name, wall time, processor time of all threads, and peak memory of the
// process at its end.
struct BuildStage {
  std::string name;
  double seconds = 0;
  double processor_seconds = 0;
  double peak_mb = 0;
};

// Creates the store at `path`, which must not exist, with these clips and without a model. Each
// motion file is one line, so almost all bytes of the store are read at a start.
absl::Status MakeClipStore(const std::string& path, double frame_rate_hz,
                           std::vector<core::BuildInput> clips);

// Builds and stores the model of the store's clips. Returns the stages; the last peak is that of
// the whole build.
absl::StatusOr<std::vector<BuildStage>> RebuildStore(const std::string& path,
                                                     const core::ParallelFor& parallel);

// Calls both with varied clips.
absl::StatusOr<std::vector<BuildStage>> MakeLargeStore(const std::string& path,
                                                       const VariedSize& size, std::uint64_t seed,
                                                       const core::ParallelFor& parallel);

// Adds clips to the large database of a store, each with a file of one line.
absl::Status AddClips(storage::MotionStore& store, std::vector<core::BuildInput> inputs);

// Returns a field of /proc/self/status in megabytes (10^6 bytes): "VmRSS", "VmHWM".
double ProcessMegabytes(const std::string& field);

}  // namespace motiondb::tests
