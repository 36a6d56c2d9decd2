#include "core/calibration/held_out.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "core/model/clip_mask.h"
#include "core/model/even_spread.h"
#include "core/model/label_units.h"
#include "core/model/model.h"

namespace motiondb::core {

std::vector<bool> LeftOutWith(const Model& model, const LabelUnit& held_out) {
  const std::vector<ModelClip>& clips = model.clips();
  const std::string& subject = clips[held_out.clip].subject;
  const bool leave_out_subject =
      !subject.empty() &&
      std::ranges::any_of(model.action_units()->all(), [&](const LabelUnit& unit) {
        return unit.label == held_out.label && clips[unit.clip].subject != subject;
      });
  std::vector<bool> left_out(clips.size());
  for (std::size_t c = 0; c < clips.size(); ++c) {
    left_out[c] =
        static_cast<int>(c) == held_out.clip || (leave_out_subject && clips[c].subject == subject);
  }
  return left_out;
}

std::shared_ptr<const ClipMask> MaskWithout(const Model& model, std::vector<bool> left_out) {
  left_out.flip();
  auto mask = ClipMask::Create(model, std::move(left_out));
  return mask.ok() ? *std::move(mask) : nullptr;
}

std::vector<LabelUnit> SampleUnits(const Model& model, int max_count) {
  std::vector<LabelUnit> order = model.action_units()->all();
  // Labels are numbered in alphabetical order.
  std::ranges::stable_sort(order, [&](const LabelUnit& a, const LabelUnit& b) {
    return std::tie(a.label, model.clips()[a.clip].subject) <
           std::tie(b.label, model.clips()[b.clip].subject);
  });
  std::vector<LabelUnit> sample;
  for (const int i : SpreadEvenly(std::ssize(order), max_count)) sample.push_back(order[i]);
  return sample;
}

StateSequence StoredMotion(const Model& model, int clip) {
  return StoredMotion(model, clip, 0, model.clips()[clip].frame_count);
}

StateSequence StoredMotion(const Model& model, const LabelUnit& unit) {
  const int first = unit.first_frame - model.clips()[unit.clip].first_frame;
  return StoredMotion(model, unit.clip, first, first + unit.frame_count);
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
