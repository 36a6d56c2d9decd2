#include "core/calibration/held_out.h"

#include <algorithm>
#include <cstdint>

namespace motiondb::core {

std::vector<int> SpreadEvenly(int count, int most) {
  const int kept = std::min(count, most);
  std::vector<int> spread;
  for (int i = 0; i < kept; ++i) {
    spread.push_back(static_cast<int>(std::int64_t{i} * count / kept));
  }
  return spread;
}

std::vector<int> ClipsLeft(const Model& model, int held_out) {
  const std::vector<ModelClip>& clips = model.clips();
  const ModelClip& out = clips[held_out];
  const bool by_subject =
      !out.subject.empty() && std::any_of(clips.begin(), clips.end(), [&](const ModelClip& clip) {
        return clip.label == out.label && clip.subject != out.subject;
      });
  std::vector<int> left;
  for (int c = 0; c < static_cast<int>(clips.size()); ++c) {
    if (c == held_out || (by_subject && clips[c].subject == out.subject)) continue;
    left.push_back(c);
  }
  return left;
}

StateSequence StoredMotion(const Model& model, int clip) {
  const ModelClip& stored = model.clips()[clip];
  StateSequence motion{model.settings().frame_rate_hz, stored.leg_length_m,
                       model.states().middleRows(stored.first_frame, stored.frame_count),
                       model.root_path().middleRows(stored.first_frame, stored.frame_count)};
  model.scale().Revert(motion.states);
  return motion;
}

}  // namespace motiondb::core
