#include "client/cli/file_failures.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <map>
#include <string_view>

#include "absl/strings/ascii.h"
#include "client/cli/terminal/print.h"
#include "text/display_text.h"

namespace motiondb::client {

namespace {

constexpr std::size_t kPathsOfGroup = 5;

// Returns the message without path and line.
std::string_view ReasonOf(const FileFailure& failure) {
  std::string_view reason = failure.detail;
  reason.remove_prefix(1);
  const std::size_t line_end = reason.find_first_not_of("0123456789");
  if (line_end > 0 && reason.substr(std::min(line_end, reason.size())).starts_with(':')) {
    reason.remove_prefix(line_end + 1);
  }
  reason.remove_prefix(std::min(reason.find_first_not_of(' '), reason.size()));
  return reason;
}

bool IsDigit(char c) { return absl::ascii_isdigit(static_cast<unsigned char>(c)); }

// Returns the text without what differs between files: each number, name in quotes and request id
// is replaced by '#'. A '-' after a word is a hyphen, not a sign.
std::string WithoutDetails(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    constexpr std::string_view kRequest = "(request ";
    const std::size_t quoted = text.front() == '\'' ? text.find('\'', 1) : std::string_view::npos;
    const std::size_t request =
        text.starts_with(kRequest) ? text.find(')') : std::string_view::npos;
    if (const std::size_t end = std::min(quoted, request); end != std::string_view::npos) {
      result += '#';
      text.remove_prefix(end + 1);
      continue;
    }
    const bool after_word =
        !result.empty() && absl::ascii_isalnum(static_cast<unsigned char>(result.back()));
    const bool has_sign = text.front() == '-' && !after_word;
    std::size_t length = 1;
    if (IsDigit(text.front()) || (has_sign && text.size() > 1 && IsDigit(text[1]))) {
      double number = 0;
      const auto parsed = std::from_chars(text.data(), text.data() + text.size(), number);
      length = static_cast<std::size_t>(parsed.ptr - text.data());
      result += '#';
    } else {
      result += text.front();
    }
    text.remove_prefix(length);
  }
  return result;
}

using FailureGroup = std::vector<const FileFailure*>;

// Groups by reason, in order of the first failure of each.
std::vector<FailureGroup> GroupByReason(const std::vector<FileFailure>& failures) {
  std::vector<FailureGroup> groups;
  std::map<std::string, std::size_t> group_of_reason;
  for (const FileFailure& failure : failures) {
    const auto [found, is_new] =
        group_of_reason.try_emplace(WithoutDetails(ReasonOf(failure)), groups.size());
    if (is_new) groups.emplace_back();
    groups[found->second].push_back(&failure);
  }
  return groups;
}

}  // namespace

FileFailure FailureOf(const std::filesystem::path& path, absl::string_view text) {
  const std::string message(text);
  const std::size_t field_end = message.find_first_not_of("abcdefghijklmnopqrstuvwxyz_.");
  const bool has_field =
      field_end > 0 && message.compare(std::min(field_end, message.size()), 2, ": ") == 0;
  for (const std::size_t begin : {std::size_t{0}, has_field ? field_end + 2 : std::size_t{0}}) {
    for (const std::string& name : {path.string(), path.filename().string()}) {
      if (message.compare(begin, name.size() + 1, name + ":") == 0) {
        return {path, message.substr(begin + name.size())};
      }
    }
  }
  return {path, ": " + message};
}

void PrintFailures(const std::vector<FileFailure>& failures) {
  for (const FailureGroup& group : GroupByReason(failures)) {
    const FileFailure& first = *group.front();
    if (group.size() == 1) {
      PrintError(first.path.string() + first.detail);
      continue;
    }
    const bool is_one_text = std::ranges::all_of(
        group, [&](const FileFailure* failure) { return ReasonOf(*failure) == ReasonOf(first); });
    PrintError(fmt::format("{} files{} {}", group.size(),
                           is_one_text ? ":" : "; the first:", ReasonOf(first)));
    const std::size_t shown = std::min(group.size(), kPathsOfGroup);
    for (std::size_t i = 0; i < shown; ++i) {
      fmt::print(stderr, "    {}\n", text::SafeText(group[i]->path.string()));
    }
    if (group.size() > shown) fmt::print(stderr, "    ... and {} more\n", group.size() - shown);
  }
}

}  // namespace motiondb::client
