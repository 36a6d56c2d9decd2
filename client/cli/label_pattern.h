// A pattern that reads the label and the subject of a clip from its path.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace motiondb::client {

// Components of a path, separated by '/', such as "{subject}/{label}_*". Within a component,
// {label} and {subject} match at least one character, and '*' any text; each matches as little as
// possible, from left to right. Other text matches itself.
class LabelPattern {
 public:
  struct Labels {
    std::string label;
    std::string subject;  // empty without {subject}
  };

  // INVALID_ARGUMENT, with what was expected: no {label}, a placeholder twice or unknown, "**", or
  // an empty component.
  static absl::StatusOr<LabelPattern> Parse(std::string_view pattern);

  // Matches the last components of the path. If the last component of the pattern contains no dot,
  // the file name is matched without its extension. ".." matches nothing: it names no folder.
  std::optional<Labels> Match(const std::filesystem::path& path) const;

 private:
  enum class Kind { kText, kAnything, kLabel, kSubject };
  struct Part {
    Kind kind;
    std::string text;
  };
  using Component = std::vector<Part>;

  static absl::StatusOr<Component> ParseComponent(std::string_view text);
  static bool MatchComponent(const Component& component, std::string_view name, Labels& labels);
  int CountOf(Kind kind) const;

  std::vector<Component> components_;
  bool matches_extension_ = false;
};

}  // namespace motiondb::client
