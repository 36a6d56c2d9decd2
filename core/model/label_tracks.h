// The labels of a clip: labelled runs of frames on named tracks.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"

namespace motiondb::core {

// The track of the label of a whole clip, and of queries that name none.
inline constexpr char kActionTrack[] = "action";

struct LabelSpan {
  // Frame count of a span to the end of its clip, until the length of the clip is known.
  static constexpr std::int32_t kToEnd = -1;

  std::string label;
  std::int32_t first_frame = 0;  // relative to the clip
  std::int32_t frame_count = kToEnd;

  bool operator==(const LabelSpan&) const = default;
};

class LabelTracks {
 public:
  LabelTracks() = default;
  // One label for all frames, on kActionTrack; empty: no label. Implicit, because most clips have
  // one label.
  LabelTracks(std::string label);  // NOLINT(google-explicit-constructor)
  LabelTracks(const char* label) : LabelTracks(std::string(label)) {}  // NOLINT

  // Replaces the spans of a track.
  void Set(const std::string& track, std::vector<LabelSpan> spans);

  // Returns the spans of a track; empty if it has none.
  const std::vector<LabelSpan>& Of(std::string_view track) const;
  // Tracks with spans.
  const std::map<std::string, std::vector<LabelSpan>, std::less<>>& tracks() const {
    return tracks_;
  }
  // Returns the label of the span of kActionTrack that covers all `frame_count` frames; empty if
  // there is none.
  const std::string& Whole(std::int32_t frame_count) const;

  // Replaces kToEnd by the number of frames to the end of a clip.
  void Resolve(std::int32_t frame_count);
  // INVALID_ARGUMENT if, on a track, a span has no label or no frame, is outside the clip, or
  // begins before the previous one ends. REQUIRES: the spans are resolved.
  absl::Status Check(std::int32_t frame_count) const;

  bool operator==(const LabelTracks&) const = default;

 private:
  std::map<std::string, std::vector<LabelSpan>, std::less<>> tracks_;  // without empty tracks
};

}  // namespace motiondb::core
