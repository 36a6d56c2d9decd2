#include "core/model/build_input.h"

#include <cmath>
#include <cstdint>
#include <utility>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include "core/motion/error.h"

namespace motiondb::core {

absl::Status CheckInputs(const BuildSettings& settings, const MarkerSet& marker_set,
                         const std::vector<BuildInput>& inputs) {
  if (inputs.empty()) return InvalidArgument("a model needs at least one clip");
  for (const BuildInput& input : inputs) {
    const StateSequence& states = input.states;
    if (states.frame_count() == 0 || states.root_path.rows() != states.frame_count()) {
      return InvalidArgument("clip '{}' has no frames, or not a root pose for each", input.clip_id);
    }
    if (states.states.cols() != marker_set.dimension_count()) {
      return InvalidArgument("clip '{}': expected {} dimensions, got {}", input.clip_id,
                             marker_set.dimension_count(), states.states.cols());
    }
    if (std::abs(states.frame_rate_hz - settings.frame_rate_hz) > 1e-6) {
      return InvalidArgument("clip '{}': expected {} frames a second, got {}", input.clip_id,
                             settings.frame_rate_hz, states.frame_rate_hz);
    }
    if (!states.states.allFinite() || !states.root_path.allFinite()) {
      return InvalidArgument("clip '{}' has a number that is not finite", input.clip_id);
    }
  }
  return absl::OkStatus();
}

namespace {

constexpr std::int64_t kBytesGivenBack = 64 << 20;  // at a time

// The allocator keeps what was freed between blocks that live on, and would not use it for large
// ones: without this, a build takes the memory of its clips twice until it ends.
void GiveBackFreed() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

}  // namespace

ConcatenatedInputs Concatenate(std::vector<BuildInput> inputs) {
  Eigen::Index frames = 0;
  for (const BuildInput& input : inputs) frames += input.states.frame_count();
  ConcatenatedInputs together;
  together.states.resize(frames, inputs[0].states.states.cols());
  together.root_path.resize(frames, 3);
  std::int32_t first = 0;
  for (BuildInput& input : inputs) {
    const int count = input.states.frame_count();
    together.clips.push_back({std::move(input.clip_id), std::move(input.label), first, count,
                              input.states.leg_length_m, std::move(input.subject),
                              std::move(input.states.glitches)});
    first += count;
  }
  std::int64_t freed = 0;
  for (std::size_t c = 0; c < inputs.size(); ++c) {
    const ModelClip& clip = together.clips[c];
    together.states.middleRows(clip.first_frame, clip.frame_count) = inputs[c].states.states;
    together.root_path.middleRows(clip.first_frame, clip.frame_count) = inputs[c].states.root_path;
    inputs[c].states = {};
    freed += clip.frame_count * together.states.cols() * std::int64_t{sizeof(float)};
    if (freed < kBytesGivenBack) continue;
    GiveBackFreed();
    freed = 0;
  }
  GiveBackFreed();
  return together;
}

}  // namespace motiondb::core
