#include "client/cli/label_pattern.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <utility>

#include "absl/status/status.h"

namespace motiondb::client {

absl::StatusOr<LabelPattern::Component> LabelPattern::ParseComponent(std::string_view text) {
  if (text.empty()) {
    return absl::InvalidArgumentError("expected a name before, between and after slashes");
  }
  Component component;
  while (!text.empty()) {
    Part part{Kind::kText, {}};
    std::size_t length = 1;
    if (text.front() == '*') {
      if (text.starts_with("**")) return absl::InvalidArgumentError("expected * instead of **");
      part.kind = Kind::kAnything;
    } else if (text.front() == '{') {
      length = std::min(text.find('}'), text.size() - 1) + 1;
      const std::string_view placeholder = text.substr(0, length);
      if (placeholder != "{label}" && placeholder != "{subject}") {
        return absl::InvalidArgumentError(
            fmt::format("expected {{label}} or {{subject}}, got {}", placeholder));
      }
      part.kind = placeholder == "{label}" ? Kind::kLabel : Kind::kSubject;
    } else {
      length = std::min(text.find_first_of("*{"), text.size());
      part.text = text.substr(0, length);
    }
    component.push_back(std::move(part));
    text.remove_prefix(length);
  }
  return component;
}

int LabelPattern::CountOf(Kind kind) const {
  int count = 0;
  for (const Component& component : components_) {
    count += static_cast<int>(std::ranges::count(component, kind, &Part::kind));
  }
  return count;
}

absl::StatusOr<LabelPattern> LabelPattern::Parse(std::string_view pattern) {
  LabelPattern result;
  std::string_view last;
  for (std::size_t begin = 0; begin <= pattern.size();) {
    const std::size_t end = std::min(pattern.find('/', begin), pattern.size());
    last = pattern.substr(begin, end - begin);
    begin = end + 1;
    auto component = ParseComponent(last);
    if (!component.ok()) return component.status();
    result.components_.push_back(*std::move(component));
  }
  result.matches_extension_ = last.find('.') != std::string_view::npos;
  if (result.CountOf(Kind::kLabel) == 0) {
    return absl::InvalidArgumentError("expected {label} in the pattern");
  }
  if (result.CountOf(Kind::kLabel) > 1 || result.CountOf(Kind::kSubject) > 1) {
    return absl::InvalidArgumentError("expected {label} and {subject} at most once");
  }
  return result;
}

bool LabelPattern::MatchComponent(const Component& component, std::string_view name,
                                  Labels& labels) {
  // fits[i][at]: the parts from i on match the name from `at` on. Computed from the last part to
  // the first, so that the time is proportional to parts * characters for every pattern.
  const std::size_t parts = component.size();
  std::vector<std::vector<bool>> fits(parts + 1, std::vector<bool>(name.size() + 1));
  fits[parts][name.size()] = true;
  for (std::size_t i = parts; i-- > 0;) {
    const auto& [kind, text] = component[i];
    for (std::size_t at = name.size() + 1; at-- > 0;) {
      const bool can_take_more = at < name.size() && (fits[i][at + 1] || fits[i + 1][at + 1]);
      if (kind == Kind::kText) {
        fits[i][at] = name.substr(at).starts_with(text) && fits[i + 1][at + text.size()];
      } else {
        fits[i][at] = can_take_more || (kind == Kind::kAnything && fits[i + 1][at]);
      }
    }
  }
  if (!fits[0][0]) return false;
  std::size_t at = 0;
  for (std::size_t i = 0; i < parts; ++i) {
    const auto& [kind, text] = component[i];
    std::size_t end = at + text.size();
    if (kind == Kind::kLabel || kind == Kind::kSubject) ++end;
    if (kind != Kind::kText) {
      while (!fits[i + 1][end]) ++end;
    }
    if (kind == Kind::kLabel) labels.label = name.substr(at, end - at);
    if (kind == Kind::kSubject) labels.subject = name.substr(at, end - at);
    at = end;
  }
  return true;
}

std::optional<LabelPattern::Labels> LabelPattern::Match(const std::filesystem::path& path) const {
  std::vector<std::string> names;
  for (const auto& name : path.lexically_normal().relative_path()) names.push_back(name.string());
  if (names.size() < components_.size()) return std::nullopt;
  if (!matches_extension_) names.back() = std::filesystem::path(names.back()).stem().string();
  Labels labels;
  const std::size_t first = names.size() - components_.size();
  for (std::size_t i = 0; i < components_.size(); ++i) {
    const std::string& name = names[first + i];
    if (name == ".." || !MatchComponent(components_[i], name, labels)) return std::nullopt;
  }
  return labels;
}

}  // namespace motiondb::client
