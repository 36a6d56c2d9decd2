// Names of hip, knee and ankle in ASF, BVH exporters, game rigs and optical marker sets.
#include <algorithm>
#include <string_view>

#include "core/motion/marker_set.h"

namespace motiondb::core {
namespace {

// "S" stands for left or right, "s" for l or r. Names are compared in lower case without
// separators; the first pattern that matches wins.
constexpr std::string_view kHipNames[] = {"Supleg", "Supperleg",    "sfemur", "Sthigh",
                                          "sthigh", "ccbasesthigh", "thighs", "Ship",
                                          "ship",   "shjc",         "sasi",   "sfwt"};
constexpr std::string_view kKneeNames[] = {"Sleg",  "Slowerleg", "Slowleg",     "stibia", "Sshin",
                                           "sshin", "Sknee",     "sknee",       "Scalf",  "scalf",
                                           "skjc",  "calfs",     "ccbasescalf", "skne"};
constexpr std::string_view kAnkleNames[] = {"Sfoot", "sfoot", "Sankle", "sankle",
                                            "sajc",  "foots", "sank",   "ccbasesfoot"};

// Returns a pattern for one side. The short letter is at the start, at the end or after a prefix.
std::string ForSide(std::string_view pattern, bool left) {
  constexpr std::string_view kPrefix = "ccbase";
  if (pattern.front() == 'S') return (left ? "left" : "right") + std::string(pattern.substr(1));
  std::string name(pattern);
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
int Find(const std::vector<std::string>& plain, const std::string_view (&patterns)[kCount],
         bool left) {
  for (std::string_view pattern : patterns) {
    const auto at = std::find(plain.begin(), plain.end(), ForSide(pattern, left));
    if (at != plain.end()) return static_cast<int>(at - plain.begin());
  }
  return -1;
}

}  // namespace

std::string PlainName(std::string_view name) {
  if (const auto colon = name.rfind(':'); colon != name.npos) name.remove_prefix(colon + 1);
  std::string plain;
  for (const char c : name) {
    if (c >= 'A' && c <= 'Z') plain += static_cast<char>(c - 'A' + 'a');
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) plain += c;
  }
  return plain;
}

Landmarks RecognizeLandmarks(const std::vector<std::string>& names) {
  std::vector<std::string> plain;
  for (const std::string& name : names) plain.push_back(PlainName(name));
  Landmarks landmarks;
  landmarks.left_hip = Find(plain, kHipNames, true);
  landmarks.right_hip = Find(plain, kHipNames, false);
  for (const bool left : {true, false}) {
    const int hip = left ? landmarks.left_hip : landmarks.right_hip;
    const int knee = Find(plain, kKneeNames, left);
    const int ankle = Find(plain, kAnkleNames, left);
    if (hip >= 0 && knee >= 0 && ankle >= 0) landmarks.legs.push_back({hip, knee, ankle});
  }
  return landmarks;
}

}  // namespace motiondb::core
