#include "client/cli/clip_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "absl/status/status.h"

namespace motiondb::client {
namespace {

// Takes the text up to the separator, or all of it, off the front.
std::string_view TakeUntil(std::string_view& text, char separator) {
  const size_t end = text.find(separator);
  const std::string_view taken = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  return taken;
}

std::string_view TakeLine(std::string_view& text) {
  std::string_view line = TakeUntil(text, '\n');
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

std::vector<std::string> Cells(std::string_view line) {
  std::vector<std::string> cells;
  const auto count = std::count(line.begin(), line.end(), '\t') + 1;
  for (auto i = 0; i < count; ++i) cells.emplace_back(TakeUntil(line, '\t'));
  return cells;
}

// Where each known column stands.
struct Columns {
  size_t count = 0;
  std::optional<size_t> path, label, subject, skeleton;
};

Columns ReadHeader(const std::vector<std::string>& titles) {
  Columns columns;
  columns.count = titles.size();
  for (size_t i = 0; i < titles.size(); ++i) {
    if (titles[i] == "path") columns.path = i;
    if (titles[i] == "label") columns.label = i;
    if (titles[i] == "subject") columns.subject = i;
    if (titles[i] == "skeleton") columns.skeleton = i;
  }
  return columns;
}

}  // namespace

absl::StatusOr<std::vector<ClipEntry>> ParseClipList(const std::filesystem::path& list_file,
                                                     std::string_view text) {
  // Spreadsheets put a byte-order mark in front.
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
  const std::filesystem::path folder = list_file.parent_path();
  std::optional<Columns> columns;
  std::vector<ClipEntry> entries;
  for (int line_number = 1; !text.empty(); ++line_number) {
    const std::string_view line = TakeLine(text);
    if (line.find_first_not_of(" \t") == std::string_view::npos || line.front() == '#') continue;
    const auto error = [&](const std::string& what) {
      return absl::InvalidArgumentError(
          fmt::format("{}:{}: {}", list_file.string(), line_number, what));
    };
    const std::vector<std::string> cells = Cells(line);
    if (!columns) {
      columns = ReadHeader(cells);
      if (!columns->path || !columns->label) {
        return error(
            "expected a header line that names the columns, \"path\" and \"label\" among them");
      }
      continue;
    }
    if (cells.size() != columns->count) {
      return error(fmt::format("expected {} cells, separated by tabs, found {}", columns->count,
                               cells.size()));
    }
    const auto cell = [&](const std::optional<size_t>& column) {
      return column ? cells[*column] : std::string();
    };
    if (cell(columns->path).empty()) return error("expected a path, found nothing");
    ClipEntry entry{folder / cell(columns->path), cell(columns->label), cell(columns->subject), {}};
    if (!cell(columns->skeleton).empty()) entry.skeleton = folder / cell(columns->skeleton);
    entries.push_back(std::move(entry));
  }
  if (!columns) {
    return absl::InvalidArgumentError(
        fmt::format("{}:1: expected a header line with \"path\" and \"label\", found nothing",
                    list_file.string()));
  }
  return entries;
}

}  // namespace motiondb::client
