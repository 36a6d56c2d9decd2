#include "client/cli/clip_files.h"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <optional>
#include <system_error>
#include <utility>

#include "absl/status/status.h"
#include "client/cli/file_formats.h"

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

// Removes and returns the text before the separator, or all of it.
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

std::vector<std::string> Cells(std::string_view line) {
  std::vector<std::string> cells;
  const auto count = std::count(line.begin(), line.end(), '\t') + 1;
  cells.reserve(static_cast<std::size_t>(count));
  for (auto i = 0; i < count; ++i) cells.emplace_back(TakeUntil(line, '\t'));
  return cells;
}

// Indices of the known columns.
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
  // Spreadsheet programs write a byte-order mark.
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
        return error("expected a header line that names the columns, with \"path\" and \"label\"");
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
