// Recognize requests and responses for tests of the plots.
#pragma once

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <limits>
#include <string>
#include <vector>

namespace motiondb::tests {

// Windows of 0.4 s every 0.1 s. `log_probability(clip, window)` is the score of a clip. The label
// of the best clip wins.
template <typename LogProbability>
v1::RecognizeResponse Answer(int layer, int windows, const std::vector<std::string>& clip_labels,
                             const LogProbability& log_probability) {
  v1::RecognizeResponse response;
  for (int w = 0; w < windows; ++w) {
    v1::RecognitionWindow& window = *response.add_windows();
    window.set_start_seconds(0.1 * w);
    window.set_end_seconds(0.1 * w + 0.4);
    window.set_layer(layer);
    double best = -std::numeric_limits<double>::infinity();
    for (int c = 0; c < static_cast<int>(clip_labels.size()); ++c) {
      v1::ClipProbability& clip = *window.add_clips();
      clip.set_clip(fmt::format("databases/walks/clips/clip-{:03}", c));
      clip.set_label(clip_labels[c]);
      clip.set_log_probability(log_probability(c, w));
      if (window.labels_size() == 0) window.add_labels()->set_label(clip_labels[c]);
      if (!(clip.log_probability() > best)) continue;
      best = clip.log_probability();
      window.mutable_labels(0)->set_label(clip_labels[c]);
    }
  }
  return response;
}

// Clips 0 and 1 are walk, clip 2 is jog. The observation is jog from window 5.
inline v1::RecognizeResponse WalkThenJog(int layer, int windows = 10) {
  return Answer(layer, windows, {"walk", "walk", "jog"}, [](int clip, int window) {
    return (clip == 2) == (window >= 5) ? -3.0 - clip : -1000.0 * (clip + 1);
  });
}

inline v1::RecognizeRequest RecognizeWalks() {
  v1::RecognizeRequest request;
  request.set_database("databases/walks");
  request.mutable_observation()->mutable_file()->set_file_name("07_06.amc");
  return request;
}

inline int Count(const std::string& text, const std::string& part) {
  int count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

}  // namespace motiondb::tests
