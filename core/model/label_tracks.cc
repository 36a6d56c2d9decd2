#include "core/model/label_tracks.h"

#include <utility>

#include "core/motion/error.h"

namespace motiondb::core {

LabelTracks::LabelTracks(std::string label) {
  if (!label.empty()) tracks_[kActionTrack].push_back({std::move(label)});
}

void LabelTracks::Set(const std::string& track, std::vector<LabelSpan> spans) {
  if (spans.empty()) {
    tracks_.erase(track);
  } else {
    tracks_[track] = std::move(spans);
  }
}

const std::vector<LabelSpan>& LabelTracks::Of(std::string_view track) const {
  static const std::vector<LabelSpan> kNone;
  const auto found = tracks_.find(track);
  return found == tracks_.end() ? kNone : found->second;
}

const std::string& LabelTracks::Whole(std::int32_t frame_count) const {
  static const std::string kNone;
  const std::vector<LabelSpan>& spans = Of(kActionTrack);
  if (spans.size() != 1 || spans[0].first_frame != 0) return kNone;
  const std::int32_t covered = spans[0].frame_count;
  return covered == LabelSpan::kToEnd || covered == frame_count ? spans[0].label : kNone;
}

void LabelTracks::Resolve(std::int32_t frame_count) {
  for (auto& [track, spans] : tracks_) {
    for (LabelSpan& span : spans) {
      if (span.frame_count == LabelSpan::kToEnd) span.frame_count = frame_count - span.first_frame;
    }
  }
}

absl::Status LabelTracks::Check(std::int32_t frame_count) const {
  for (const auto& [track, spans] : tracks_) {
    std::int32_t next = 0;
    for (const LabelSpan& span : spans) {
      if (track.empty() || span.label.empty() || span.first_frame < next || span.frame_count < 1 ||
          span.frame_count > frame_count - span.first_frame) {
        return InvalidArgument(
            "track '{}': expected labels on ascending, disjoint spans within {} frames, got '{}' "
            "on {} frames from frame {}",
            track, frame_count, span.label, span.frame_count, span.first_frame);
      }
      next = span.first_frame + span.frame_count;
    }
  }
  return absl::OkStatus();
}

}  // namespace motiondb::core
