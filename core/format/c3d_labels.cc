#include "core/format/c3d_labels.h"

#include <fmt/format.h>

#include <set>

#include "core/format/text_scanner.h"
#include "core/format/unique_names.h"

namespace motiondb::core {
namespace {

// The strings of NAME, NAME2, NAME3 ...: one parameter holds at most 255.
std::vector<std::string_view> AllStrings(const C3dParameters& parameters, const std::string& name) {
  std::vector<std::string_view> all = parameters.Strings("POINT", name);
  for (int n = 2;; ++n) {
    const auto more = parameters.Strings("POINT", fmt::format("{}{}", name, n));
    if (more.empty() || all.size() >= C3dParameters::kMostStrings) return all;
    all.insert(all.end(), more.begin(), more.end());
  }
}

std::set<std::string_view> ComputedLabels(const C3dParameters& parameters) {
  std::set<std::string_view> computed;
  for (const char* kind : {"ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS"}) {
    for (const std::string_view label : AllStrings(parameters, kind)) computed.insert(label);
  }
  computed.erase("");
  return computed;
}

// The "subject:" that all labels begin with; empty if they differ.
std::string_view CommonSubject(const std::vector<std::string_view>& labels) {
  std::string_view subject;
  for (const std::string_view label : labels) {
    const auto colon = label.rfind(':');
    if (label.empty() || label[0] == '*') continue;  // not named by a person
    if (colon == label.npos) return {};
    if (subject.empty()) subject = label.substr(0, colon + 1);
    if (label.substr(0, colon + 1) != subject) return {};
  }
  return subject;
}

}  // namespace

std::vector<C3dMarker> C3dMarkers(const C3dParameters& parameters, int points,
                                  std::vector<std::string>& notes) {
  const std::vector<std::string_view> labels = AllStrings(parameters, "LABELS");
  const std::set<std::string_view> computed = ComputedLabels(parameters);
  const std::string_view subject = CommonSubject(labels);
  UniqueNames unique;
  std::vector<C3dMarker> markers;
  int left_out = 0;
  int unnamed = 0;
  for (std::size_t point = 0; point < static_cast<std::size_t>(points); ++point) {
    std::string_view label = point < labels.size() ? labels[point] : std::string_view();
    if (computed.contains(label)) {
      ++left_out;
      continue;
    }
    if (label.starts_with(subject)) label.remove_prefix(subject.size());
    if (label.empty()) ++unnamed;
    markers.push_back({.point = point,
                       .name = unique.Add(label.empty() ? fmt::format("point{}", point + 1)
                                                        : std::string(label))});
  }
  if (!subject.empty()) notes.push_back(fmt::format("'{}' dropped from labels", Shown(subject)));
  if (unnamed > 0) notes.push_back(fmt::format("{} points without a label", unnamed));
  if (left_out > 0) {
    notes.push_back(fmt::format("{} computed points (angles, forces ...) left out", left_out));
  }
  if (std::string note = unique.Note(); !note.empty()) notes.push_back(std::move(note));
  return markers;
}

}  // namespace motiondb::core
