#include "core/calibration/held_out.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "core/model/even_spread.h"
#include "core/model/model.h"

namespace motiondb::core {

std::vector<bool> LeftOutWith(const Model& model, int held_out) {
  const std::vector<ModelClip>& clips = model.clips();
  const ModelClip& tested = clips[held_out];
  const bool leave_out_subject =
      !tested.subject.empty() &&
      std::any_of(clips.begin(), clips.end(), [&](const ModelClip& clip) {
        return clip.label == tested.label && clip.subject != tested.subject;
      });
  std::vector<bool> left_out(clips.size());
  for (std::size_t c = 0; c < clips.size(); ++c) {
    left_out[c] = static_cast<int>(c) == held_out ||
                  (leave_out_subject && clips[c].subject == tested.subject);
  }
  return left_out;
}

std::vector<int> SampleClips(const Model& model, int max_count) {
  const std::vector<ModelClip>& clips = model.clips();
  std::vector<int> order(clips.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](int a, int b) {
    return std::tie(clips[a].label, clips[a].subject) < std::tie(clips[b].label, clips[b].subject);
  });
  std::vector<int> sample;
  for (const int i : SpreadEvenly(std::ssize(order), max_count)) sample.push_back(order[i]);
  return sample;
}

StateSequence StoredMotion(const Model& model, int clip) {
  return StoredMotion(model, clip, 0, model.clips()[clip].frame_count);
}

StateSequence StoredMotion(const Model& model, int clip, int first, int end) {
  const ModelClip& stored = model.clips()[clip];
  StateSequence motion{model.settings().frame_rate_hz, stored.leg_length_m,
                       model.states().middleRows(stored.first_frame + first, end - first),
                       model.root_path().middleRows(stored.first_frame + first, end - first)};
  model.scale().Revert(motion.states);
  return motion;
}

}  // namespace motiondb::core
