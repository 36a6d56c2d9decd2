#include "client/tab_separated.h"

#include <fmt/format.h>

#include <utility>

namespace motiondb::client {
namespace {

// Removes and returns the text before the separator, or all of it.
std::string_view TakeUntil(std::string_view& text, char separator) {
  const size_t end = text.find(separator);
  const std::string_view taken = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  return taken;
}

}  // namespace

TabSeparated::TabSeparated(std::string file, std::string_view text)
    : file_(std::move(file)), rest_(text) {
  if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
}

bool TabSeparated::Next(std::vector<std::string_view>& cells) {
  while (!rest_.empty()) {
    ++line_;
    std::string_view line = TakeUntil(rest_, '\n');
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.find_first_not_of(" \t") == std::string_view::npos || line.front() == '#') continue;
    cells.clear();
    while (line.find('\t') != std::string_view::npos) cells.push_back(TakeUntil(line, '\t'));
    cells.push_back(line);
    return true;
  }
  return false;
}

std::string TabSeparated::Place() const { return fmt::format("{}:{}", file_, line_); }

absl::Status TabSeparated::Error(const std::string& what) const {
  return absl::InvalidArgumentError(fmt::format("{}: {}", Place(), what));
}

absl::Status TabSeparated::CheckCellCount(std::size_t expected, std::size_t found) const {
  if (expected == found) return absl::OkStatus();
  return Error(fmt::format("expected {} cells, separated by tabs, found {}", expected, found));
}

}  // namespace motiondb::client
