// Random valid annotations for property tests.
#pragma once

#include <motiondb/annotation_file.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace motiondb::tests {

inline constexpr double kRandomClipSeconds = 30;

// Returns annotations of `clips` clips "clip0", ... on `tracks` tracks each, without overlaps on a
// track, in order of clip, track and start. Their texts are UTF-8 with quotes and blanks inside.
inline std::vector<client::Annotation> RandomAnnotations(unsigned seed, int clips, int tracks) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const std::vector<std::string> labels = {"walk",          "say \"stop\"",    "a, b; c",
                                           "\xC3\xA9tirer", "<exists>",        "! no comment",
                                           "1.5",           "\xF0\x9F\x9A\xB6"};
  const std::vector<std::string> names = {"action", "carries", "left-arm", "t_4"};
  const std::vector<std::string> sources = {"", "person", "import", "suggestion"};
  std::vector<client::Annotation> annotations;
  for (int clip = 0; clip < clips; ++clip) {
    for (int track = 0; track < tracks; ++track) {
      for (double time = uniform(0, 2); time < kRandomClipSeconds - 3;) {
        client::Annotation& annotation = annotations.emplace_back();
        annotation.clip = "clip" + std::to_string(clip);
        annotation.track = names[static_cast<std::size_t>(track)];
        annotation.label = labels[random() % labels.size()];
        annotation.start_seconds = time;
        annotation.end_seconds = time + uniform(0.01, 3);
        if (random() % 2 == 0) annotation.confidence = uniform(0, 1);
        annotation.source = sources[random() % sources.size()];
        time = *annotation.end_seconds + (random() % 2 == 0 ? 0 : uniform(0, 1));
      }
    }
  }
  return annotations;
}

// The clips of the annotations.
inline std::vector<client::AnnotatedClip> RandomClips(int clips) {
  std::vector<client::AnnotatedClip> result;
  for (int clip = 0; clip < clips; ++clip) {
    const std::string name = "clip" + std::to_string(clip);
    result.push_back({name, name + ".bvh", kRandomClipSeconds});
  }
  return result;
}

// Returns the annotations without their places.
inline std::vector<client::Annotation> WithoutPlaces(std::vector<client::Annotation> annotations) {
  for (client::Annotation& annotation : annotations) annotation.place.clear();
  return annotations;
}

}  // namespace motiondb::tests
