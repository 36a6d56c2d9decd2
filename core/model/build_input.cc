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
  if (inputs.empty()) return InvalidArgument("expected at least one clip, got none");
  for (const BuildInput& input : inputs) {
    const StateSequence& states = input.states;
    if (states.frame_count() == 0 || states.root_path.rows() != states.frame_count()) {
      return InvalidArgument(
          "clip '{}': expected at least one frame and a root pose for each frame", input.clip_id);
    }
    if (states.states.cols() != marker_set.dimension_count()) {
      return InvalidArgument("clip '{}': expected {} dimensions, got {}", input.clip_id,
                             marker_set.dimension_count(), states.states.cols());
    }
    if (std::abs(states.frame_rate_hz - settings.frame_rate_hz) > 1e-6) {
      return InvalidArgument("clip '{}': expected {} Hz, got {} Hz", input.clip_id,
                             settings.frame_rate_hz, states.frame_rate_hz);
    }
    if (!states.states.allFinite() || !states.root_path.allFinite()) {
      return InvalidArgument("clip '{}': expected finite states and root path", input.clip_id);
    }
    LabelTracks labels = input.labels;
    labels.Resolve(states.frame_count());
    if (const absl::Status fits = labels.Check(states.frame_count()); !fits.ok()) {
      return InvalidArgument("clip '{}': {}", input.clip_id, std::string(fits.message()));
    }
  }
  return absl::OkStatus();
}

namespace {

constexpr std::int64_t kFreedBytes = 64 << 20;  // freed between two calls of malloc_trim

// Returns freed memory to the operating system. Otherwise fragmentation doubles the memory that a
// build needs for its clips.
void ReturnFreedMemory() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

}  // namespace

ConcatenatedInputs Concatenate(std::vector<BuildInput> inputs) {
  Eigen::Index frames = 0;
  for (const BuildInput& input : inputs) frames += input.states.frame_count();
  ConcatenatedInputs concatenated;
  concatenated.states.resize(frames, inputs[0].states.states.cols());
  concatenated.root_path.resize(frames, 3);
  std::int32_t first = 0;
  for (BuildInput& input : inputs) {
    const int count = input.states.frame_count();
    concatenated.clips.push_back({std::move(input.clip_id), std::move(input.labels), first, count,
                                  input.states.leg_length_m, std::move(input.subject),
                                  std::move(input.states.glitches)});
    concatenated.clips.back().labels.Resolve(count);
    first += count;
  }
  std::int64_t freed = 0;
  for (std::size_t c = 0; c < inputs.size(); ++c) {
    const ModelClip& clip = concatenated.clips[c];
    concatenated.states.middleRows(clip.first_frame, clip.frame_count) = inputs[c].states.states;
    concatenated.root_path.middleRows(clip.first_frame, clip.frame_count) =
        inputs[c].states.root_path;
    inputs[c].states = {};
    freed += clip.frame_count * concatenated.states.cols() * std::int64_t{sizeof(float)};
    if (freed < kFreedBytes) continue;
    ReturnFreedMemory();
    freed = 0;
  }
  ReturnFreedMemory();
  return concatenated;
}

}  // namespace motiondb::core
