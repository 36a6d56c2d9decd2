// A large database for benchmarks, made from the recorded clips by a seeded generator. No two of
// its clips are alike. Each starts from one recorded clip and goes on through others of its label,
// and each has, drawn for it alone:
//   time     a smooth, monotone warp: 0.7 to 1.4 times the recorded speed
//   side     left and right exchanged, or not
//   order    which takes of the label follow, from where on, cross-faded over 0.4 s
//   size     0.85 to 1.15 of the subject's, then trunk, head and arms against the legs
//   manner   up to 30 % of another take's posture, reach of movements 0.9 to 1.1, limbs that sway
//            slowly by up to 7 degrees
// States are then computed from the varied world positions, as for any clip, so velocities are
// those of the varied paths. Safe to call from any thread; uses only the threads lent to it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "absl/status/statusor.h"
#include "core/model/model_builder.h"
#include "core/tree/feature_scale.h"
#include "core/tree/parallel.h"

namespace motiondb::tests {

// What a table says of the data that it was measured on.
inline constexpr char kVariedMotion[] =
    "recorded clips, varied (time-warped, mirrored, sizes and manners mixed) by a seeded generator";

struct VariedSize {
  int clips = 2000;
  int frames = 1'000'000;  // of all clips together; at least 8 for each
  double frame_rate_hz = 60;
};

// Clips on the standard markers from the folder of recorded motion. The same size and seed give the
// same clips on any number of threads. NOT_FOUND or INVALID_ARGUMENT name the file or the number
// that is wrong.
absl::StatusOr<std::vector<core::BuildInput>> VariedClips(const std::filesystem::path& data,
                                                          const VariedSize& size,
                                                          std::uint64_t seed,
                                                          const core::ParallelFor& parallel);

// The frames of all those clips in order, divided by their scale: frames x 204, what a tree is
// built from. Errors as above.
absl::StatusOr<core::FrameMatrix> VariedStates(const std::filesystem::path& data,
                                               const VariedSize& size, std::uint64_t seed,
                                               const core::ParallelFor& parallel,
                                               core::Scaling scaling = core::Scaling::kKind);

}  // namespace motiondb::tests
