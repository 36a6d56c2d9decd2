#include "client/cli/ingest_batch.h"

#include <fmt/format.h>
#include <motiondb/v1/clip.pb.h>

#include <algorithm>
#include <optional>

#include "absl/status/status.h"
#include "client/call_failure.h"
#include "client/cli/database_text.h"
#include "client/cli/print.h"
#include "client/cli/progress_bar.h"
#include "client/cli/rebuild_wait.h"
#include "client/cli/resource_name.h"
#include "text/display_text.h"

namespace motiondb::client {

namespace {

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

namespace {

// Returns "PATH: message". Messages of file readers already contain the file name, without folder.
std::string Failure(const std::filesystem::path& path, const absl::Status& status) {
  const std::string message(status.message());
  for (const std::string& name : {path.string(), path.filename().string()}) {
    if (message.rfind(name + ":", 0) == 0) return path.string() + message.substr(name.size());
  }
  return fmt::format("{}: {}", path.string(), message);
}

}  // namespace

IngestBatch::IngestBatch(const Client& client, std::string database, SourceOptions source,
                         bool json)
    : client_(client), database_(std::move(database)), source_(std::move(source)), json_(json) {}

absl::Status IngestBatch::Send(const std::vector<ClipEntry>& clips) {
  ProgressBar bar;
  for (size_t i = 0; i < clips.size(); ++i) {
    const ClipEntry& clip = clips[i];
    bar.Show(static_cast<double>(i) / static_cast<double>(clips.size()),
             fmt::format("{} of {}  {}", i + 1, clips.size(), clip.path.filename().string()));
    const auto response = SendOne(clip);
    bar.Clear();
    if (response.ok()) {
      Stored(*response);
      continue;
    }
    failures_.push_back(Failure(clip.path, response.status()));
    if (absl::IsUnavailable(response.status())) {
      return absl::UnavailableError(
          fmt::format("stopped after {} of {}; {}; `motiondb list {}` shows whether the last file "
                      "is stored",
                      i, CountText(clips.size(), "file"), StoredText(), ShortName(database_)));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<v1::IngestClipResponse> IngestBatch::SendOne(const ClipEntry& clip) const {
  const auto skeleton = SkeletonFor(clip.path, clip.skeleton);
  if (!skeleton.ok()) return skeleton.status();
  const std::pair<const char*, std::string> texts[] = {
      {"label", clip.label}, {"subject", clip.subject}, {"name", clip.path.filename().string()}};
  for (const auto& [what, text] : texts) {
    if (text::IsUtf8(text)) continue;
    return absl::InvalidArgumentError(fmt::format("the {} is not UTF-8 text", what));
  }
  v1::IngestClipHeader header;
  header.set_parent(database_);
  header.set_label(clip.label);
  header.set_subject(clip.subject);
  *header.mutable_conventions() = Conventions(source_);
  return client_.IngestFile(header, clip.path, *skeleton);
}

void IngestBatch::Stored(const v1::IngestClipResponse& response) {
  ++stored_clips_;
  stored_frames_ += response.clip().frame_count();
  // The last requested rebuild includes all clips, because it begins after they were stored.
  operation_ = response.operation().name();
  if (json_) {
    PrintJson(response);
  } else {
    PrintText(IngestedClipText(response.clip()));
  }
  // Flushes, so that a script knows the stored clips even if this process is killed.
  std::fflush(stdout);
}

std::string IngestBatch::StoredText() const {
  return fmt::format("{} {} stored", CountText(stored_clips_, "clip"),
                     stored_clips_ == 1 ? "is" : "are");
}

absl::Status IngestBatch::AwaitModel() {
  if (operation_.empty()) return absl::OkStatus();
  const auto done = WaitForRebuild(client_, operation_, StoredText());
  if (!done.ok()) return done.status();
  if (json_) return absl::OkStatus();
  const auto summary = ModelSummary(client_, *done);
  if (!summary.ok()) {
    return WithMessage(summary.status(),
                       fmt::format("{}; {} and in the model",
                                   std::string(summary.status().message()), StoredText()));
  }
  PrintLine("ingested {}, {}; {}", CountText(stored_clips_, "clip"),
            CountText(stored_frames_, "frame"), *summary);
  return absl::OkStatus();
}

}  // namespace motiondb::client
