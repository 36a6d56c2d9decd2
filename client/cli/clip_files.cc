#include "client/cli/clip_files.h"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <system_error>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_split.h"
#include "client/cli/annotate/clip_edit.h"
#include "client/cli/motion_file.h"
#include "client/tab_separated.h"

namespace motiondb::client {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxInputBytes = std::size_t{64} << 20;

// Appends the motion files below a folder.
absl::Status AddMotionFiles(const fs::path& folder, std::vector<fs::path>& files) {
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const fs::path& path = entry->path();
    if (path.filename().string().starts_with('.')) continue;
    std::error_code ignored;
    if (!entry->is_directory(ignored)) {
      if (IsMotionFile(path) && entry->is_regular_file(ignored)) files.push_back(path);
    } else if (!entry->is_symlink(ignored)) {
      if (const absl::Status status = AddMotionFiles(path, files); !status.ok()) return status;
    }
  }
  if (!error) return absl::OkStatus();
  return absl::UnknownError(
      fmt::format("{}: cannot be read: {}", folder.string(), error.message()));
}

absl::Status AddFileOrFolder(const fs::path& path, std::vector<fs::path>& files) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) {
    files.push_back(path);
    return absl::OkStatus();
  }
  std::vector<fs::path> below;
  if (const absl::Status status = AddMotionFiles(path, below); !status.ok()) return status;
  if (below.empty()) {
    return absl::InvalidArgumentError(
        fmt::format("{}: has no motion files ({})", path.string(), MotionExtensions()));
  }
  std::ranges::sort(below);
  std::ranges::move(below, std::back_inserter(files));
  return absl::OkStatus();
}

bool IsPattern(const std::string& argument) {
  std::error_code ignored;
  return argument.find_first_of("*?[") != std::string::npos &&
         !fs::exists(fs::symlink_status(argument, ignored));
}

absl::Status AddMatches(const std::string& pattern, std::vector<fs::path>& files) {
  glob_t matches{};
  const int result = glob(pattern.c_str(), 0, nullptr, &matches);
  const std::vector<fs::path> paths(matches.gl_pathv, matches.gl_pathv + matches.gl_pathc);
  globfree(&matches);
  if (result == GLOB_NOSPACE) {
    return absl::ResourceExhaustedError(fmt::format("{}: out of memory", pattern));
  }
  if (paths.empty()) return absl::NotFoundError(fmt::format("{}: no file matches", pattern));
  for (const fs::path& path : paths) {
    if (const absl::Status status = AddFileOrFolder(path, files); !status.ok()) return status;
  }
  return absl::OkStatus();
}

std::string_view TakeLine(std::string_view& text) {
  const std::size_t end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

// Reads to the end. Not limited to whole lines, because an endless input may have no line end.
absl::StatusOr<std::string> ReadInput(std::istream& input) {
  std::string text;
  std::array<char, 4096> block;
  while (input.read(block.data(), block.size()) || input.gcount() > 0) {
    text.append(block.data(), static_cast<std::size_t>(input.gcount()));
    if (text.size() > kMaxInputBytes) {
      return absl::InvalidArgumentError("standard input: is larger than 64 MiB");
    }
  }
  if (input.bad()) return absl::UnknownError("standard input: cannot be read");
  return text;
}

absl::Status AddPathsOfInput(std::istream& input, std::vector<fs::path>& files) {
  const auto text = ReadInput(input);
  if (!text.ok()) return text.status();
  for (std::string_view rest = *text; !rest.empty();) {
    const std::string_view line = TakeLine(rest);
    if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
    if (const absl::Status status = AddFileOrFolder(line, files); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<fs::path>> FilesOfArguments(const std::vector<std::string>& arguments,
                                                       std::istream& input) {
  std::vector<fs::path> files;
  for (const std::string& argument : arguments) {
    const absl::Status status = argument == "-"       ? AddPathsOfInput(input, files)
                                : IsPattern(argument) ? AddMatches(argument, files)
                                                      : AddFileOrFolder(argument, files);
    if (!status.ok()) return status;
  }
  return files;
}

namespace {

constexpr std::string_view kFieldPrefix = "field.";

void SetTags(std::string_view cell, ClipEntry& entry) {
  for (const auto tag : absl::StrSplit(std::string(cell), ',', absl::SkipWhitespace())) {
    entry.tags.emplace_back(absl::StripAsciiWhitespace(tag));
  }
}

// Sets a cell that is not empty; columns without a meaning are ignored.
absl::Status SetCell(const std::filesystem::path& folder, std::string_view column,
                     std::string_view cell, ClipEntry& entry) {
  if (cell.empty()) return absl::OkStatus();
  if (column == "path") {
    entry.path = folder / cell;
  } else if (column == "label") {
    entry.label = cell;
  } else if (column == "subject") {
    entry.subject = cell;
  } else if (column == "skeleton") {
    entry.skeleton = folder / cell;
  } else if (column == "title") {
    entry.title = cell;
  } else if (column == "description") {
    entry.description = cell;
  } else if (column == "tags") {
    SetTags(cell, entry);
  } else if (column.starts_with(kFieldPrefix)) {
    auto field = ParseField(std::string(column.substr(kFieldPrefix.size())), std::string(cell));
    if (!field.ok()) return field.status();
    entry.fields.insert_or_assign(field->first, std::move(field->second));
  }
  return absl::OkStatus();
}

bool HasColumn(const std::vector<std::string_view>& columns, std::string_view name) {
  return std::ranges::find(columns, name) != columns.end();
}

}  // namespace

absl::StatusOr<std::vector<ClipEntry>> ParseClipList(const std::filesystem::path& list_file,
                                                     std::string_view text) {
  TabSeparated lines(list_file.string(), text);
  std::vector<std::string_view> columns, cells;
  if (!lines.Next(columns)) {
    return absl::InvalidArgumentError(
        fmt::format("{}:1: expected a header line with \"path\" and \"label\", found nothing",
                    list_file.string()));
  }
  if (!HasColumn(columns, "path") || !HasColumn(columns, "label")) {
    return lines.Error(
        "expected a header line that names the columns, with \"path\" and \"label\"");
  }
  const std::filesystem::path folder = list_file.parent_path();
  std::vector<ClipEntry> entries;
  while (lines.Next(cells)) {
    absl::Status status = lines.CheckCellCount(columns.size(), cells.size());
    ClipEntry entry;
    for (std::size_t i = 0; i < columns.size() && status.ok(); ++i) {
      const absl::Status set = SetCell(folder, columns[i], cells[i], entry);
      if (!set.ok()) {
        status = lines.Error(fmt::format("{}: {}", columns[i], std::string(set.message())));
      }
    }
    if (status.ok() && entry.path.empty()) status = lines.Error("expected a path, found nothing");
    if (!status.ok()) return status;
    entries.push_back(std::move(entry));
  }
  return entries;
}

}  // namespace motiondb::client
