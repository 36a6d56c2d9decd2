#include "core/model/label_units.h"

#include <algorithm>
#include <set>

#include "core/model/clip_mask.h"
#include "core/model/model.h"

namespace motiondb::core {

LabelUnits::LabelUnits(const std::vector<ModelClip>& clips, double frame_rate_hz,
                       std::string_view track, const ClipMask* mask) {
  std::set<std::string_view> labels;
  std::set<std::string_view> others;
  const auto is_used = [&](std::size_t c) { return Allows(mask, static_cast<int>(c)); };
  for (std::size_t c = 0; c < clips.size(); ++c) {
    if (!is_used(c)) continue;
    for (const auto& [name, spans] : clips[c].labels.tracks()) {
      if (name != track) {
        others.insert(name);
        continue;
      }
      for (const LabelSpan& span : spans) labels.insert(span.label);
    }
  }
  labels_.assign(labels.begin(), labels.end());
  other_tracks_.assign(others.begin(), others.end());

  const int stride = FrameStride(frame_rate_hz);
  int first_row = 0;  // of the clip
  begin_.reserve(clips.size() + 1);
  for (std::size_t c = 0; c < clips.size(); ++c) {
    begin_.push_back(static_cast<int>(units_.size()));
    const ModelClip& clip = clips[c];
    const auto add = [&](int label, int first, int end) {
      if (first == end) return;
      const int end_row = (end + stride - 1) / stride;
      const int row = std::min((first + stride - 1) / stride, end_row - 1);
      units_.push_back({static_cast<int>(c),
                        label,
                        clip.first_frame + first,
                        end - first,
                        {first_row + row, end_row - row}});
    };
    if (is_used(c)) {
      int next = 0;
      for (const LabelSpan& span : clip.labels.Of(track)) {
        const auto label = std::ranges::lower_bound(labels_, span.label) - labels_.begin();
        add(-1, next, span.first_frame);
        next = span.frame_count == LabelSpan::kToEnd ? clip.frame_count
                                                     : span.first_frame + span.frame_count;
        add(static_cast<int>(label), span.first_frame, next);
      }
      add(-1, next, clip.frame_count);
    }
    first_row += (clip.frame_count + stride - 1) / stride;
  }
  begin_.push_back(static_cast<int>(units_.size()));
}

std::shared_ptr<const LabelUnits> UnitsOf(const Model& model, std::string_view track,
                                          const ClipMask* mask) {
  if (track.empty() || track == kActionTrack) {
    return mask == nullptr ? model.action_units() : mask->action_units();
  }
  return std::make_shared<const LabelUnits>(model.clips(), model.settings().frame_rate_hz, track,
                                            mask);
}

}  // namespace motiondb::core
