#include "tests/eval/observations.h"

#include <algorithm>
#include <cmath>

#include "core/motion/error.h"

namespace motiondb::tests {

core::StateSequence Slice(const core::StateSequence& states, int first, int count) {
  return {states.frame_rate_hz, states.leg_length_m, states.states.middleRows(first, count),
          states.root_path.middleRows(first, count)};
}

core::MarkerMotion Slice(const core::MarkerMotion& markers, int first, int count) {
  return {markers.names, markers.frame_rate_hz, markers.positions_m.middleRows(first, count)};
}

std::vector<core::StateSequence> SplitIntoWindows(const core::StateSequence& states) {
  const auto in_frames = [&](double seconds) {
    return static_cast<int>(std::lround(seconds * states.frame_rate_hz));
  };
  const int width = std::min(in_frames(kWindowSeconds), states.frame_count());
  std::vector<core::StateSequence> windows;
  for (int first = 0; first + width <= states.frame_count(); first += in_frames(kHopSeconds)) {
    windows.push_back(Slice(states, first, width));
  }
  return windows;
}

std::vector<core::StateSequence> SplitIntoParts(const core::StateSequence& states, Extent extent) {
  if (extent == Extent::kWindow) return SplitIntoWindows(states);
  return {states};
}

absl::StatusOr<core::StateSequence> StatesOf(const core::MarkerSet& set,
                                             const core::MarkerMotion& markers,
                                             double frame_rate_hz, double leg_length_m) {
  MOTIONDB_ASSIGN_OR_RETURN(const core::MarkerMotion resampled,
                            core::Resample(markers, frame_rate_hz));
  return core::ComputeStates(set, resampled, leg_length_m);
}

absl::StatusOr<core::StateSequence> PrefixStates(const core::MarkerSet& set, const EvalClip& clip,
                                                 double share) {
  const auto all = static_cast<int>(clip.markers.positions_m.rows());
  const int count = std::clamp(static_cast<int>(std::lround(share * all)), std::min(2, all), all);
  return StatesOf(set, Slice(clip.markers, 0, count), clip.states.frame_rate_hz,
                  clip.states.leg_length_m);
}

}  // namespace motiondb::tests
