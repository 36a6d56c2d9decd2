// A large database for benchmarks, generated from the recorded clips, seeded. All clips differ.
// Each starts with one recorded clip and continues with others of its label. Drawn for each clip:
//   time     a smooth, monotone warp: 0.7 to 1.4 times the recorded speed
//   side     mirrored or not
//   order    the takes of the label that follow and where each begins, cross-faded over 0.4 s
//   size     0.85 to 1.15 of the subject's; then trunk, head and arms relative to the legs
//   manner   up to 30 % of another take's posture; reach 0.9 to 1.1; slow sway of limbs up to 7
//            degrees
// States, with their velocities, are then computed from the varied world positions.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "absl/status/statusor.h"
#include "core/model/model_builder.h"
#include "core/motion/execution.h"
#include "core/tree/feature_scale.h"

namespace motiondb::tests {

// Describes the data in the notes of a table.
inline constexpr char kVariedMotion[] =
    "recorded clips, varied (time-warped, mirrored, sizes and manners mixed) by a seeded generator";

struct VariedSize {
  int clips = 2000;
  int frames = 1'000'000;  // total of all clips; at least 8 per clip
  double frame_rate_hz = 60;
};

// Returns clips on the standard markers, made from the folder of recorded motion. The result
// depends on size and seed only, not on the threads. NOT_FOUND or INVALID_ARGUMENT names the wrong
// file or number.
absl::StatusOr<std::vector<core::BuildInput>> VariedClips(const std::filesystem::path& data,
                                                          const VariedSize& size,
                                                          std::uint64_t seed,
                                                          const core::ParallelFor& parallel);

// Returns the scaled frames of all those clips in order, frames x 204: the input of a tree. Errors
// as above.
absl::StatusOr<core::FrameMatrix> VariedStates(const std::filesystem::path& data,
                                               const VariedSize& size, std::uint64_t seed,
                                               const core::ParallelFor& parallel,
                                               core::Scaling scaling = core::Scaling::kKind);

}  // namespace motiondb::tests
