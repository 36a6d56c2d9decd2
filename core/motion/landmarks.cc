// Which names mean hip, knee and ankle: the customs of ASF, BVH exporters, game rigs and optical
// marker sets.
#include <algorithm>
#include <cctype>
#include <string_view>

#include "core/motion/marker_set.h"

namespace motiondb::core {
namespace {

// "S" stands for left or right, "s" for l or r. Names are compared in lower case without
// separators; the first custom that the motion knows wins.
constexpr std::string_view kHip[] = {"Supleg", "Supperleg",    "sfemur", "Sthigh",
                                     "sthigh", "ccbasesthigh", "thighs", "Ship",
                                     "ship",   "shjc",         "sasi",   "sfwt"};
constexpr std::string_view kKnee[] = {"Sleg",  "Slowerleg", "Slowleg",     "stibia", "Sshin",
                                      "sshin", "Sknee",     "sknee",       "Scalf",  "scalf",
                                      "skjc",  "calfs",     "ccbasescalf", "skne"};
constexpr std::string_view kAnkle[] = {"Sfoot", "sfoot", "Sankle", "sankle",
                                       "sajc",  "foots", "sank",   "ccbasesfoot"};

// Lower case, letters and digits only, and what precedes the last ':' dropped (a subject's name).
std::string Normalize(std::string_view name) {
  if (const auto colon = name.rfind(':'); colon != std::string_view::npos) {
    name.remove_prefix(colon + 1);
  }
  std::string normal;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c))) {
      normal += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return normal;
}

// A custom for one side. The side's short letter stands at the start, at the end, or after a
// prefix, where the custom has "s" in a place that cannot be part of a word.
std::string ForSide(std::string_view custom, bool left) {
  constexpr std::string_view kPrefix = "ccbase";
  if (custom.front() == 'S') return (left ? "left" : "right") + std::string(custom.substr(1));
  std::string name(custom);
  const char letter = left ? 'l' : 'r';
  if (name.starts_with(kPrefix)) {
    name[kPrefix.size()] = letter;
  } else if (name == "thighs" || name == "calfs" || name == "foots") {
    name.back() = letter;
  } else {
    name.front() = letter;
  }
  return name;
}

template <std::size_t kCount>
int Find(const std::vector<std::string>& normal, const std::string_view (&customs)[kCount],
         bool left) {
  for (std::string_view custom : customs) {
    const auto at = std::find(normal.begin(), normal.end(), ForSide(custom, left));
    if (at != normal.end()) return static_cast<int>(at - normal.begin());
  }
  return -1;
}

}  // namespace

Landmarks RecognizeLandmarks(const std::vector<std::string>& names) {
  std::vector<std::string> normal;
  for (const std::string& name : names) normal.push_back(Normalize(name));
  Landmarks landmarks;
  landmarks.left_hip = Find(normal, kHip, true);
  landmarks.right_hip = Find(normal, kHip, false);
  for (const bool left : {true, false}) {
    const int hip = left ? landmarks.left_hip : landmarks.right_hip;
    const int knee = Find(normal, kKnee, left);
    const int ankle = Find(normal, kAnkle, left);
    if (hip >= 0 && knee >= 0 && ankle >= 0) landmarks.legs.push_back({hip, knee, ankle});
  }
  return landmarks;
}

}  // namespace motiondb::core
