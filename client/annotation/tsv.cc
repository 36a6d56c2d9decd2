// Annotations as tab-separated text with a header line.
#include <fmt/format.h>

#include <array>

#include "client/annotation/formats.h"
#include "client/tab_separated.h"
#include "text/display_text.h"

namespace motiondb::client {
namespace {

enum Column { kClip, kStart, kEnd, kLabel, kTrack, kConfidence, kSource, kColumnCount };

constexpr std::array<std::string_view, kColumnCount> kColumnTitles = {
    "clip", "start", "end", "label", "track", "confidence", "source"};

// Index of each column in the file; npos: it is missing.
using ColumnIndices = std::array<std::size_t, kColumnCount>;

absl::StatusOr<ColumnIndices> ReadColumns(const TabSeparated& lines,
                                          const std::vector<std::string_view>& titles) {
  ColumnIndices indices;
  indices.fill(std::string_view::npos);
  for (std::size_t i = 0; i < titles.size(); ++i) {
    for (std::size_t column = 0; column < kColumnCount; ++column) {
      if (titles[i] != kColumnTitles[column]) continue;
      if (indices[column] != std::string_view::npos) {
        return lines.Error(fmt::format("expected the column \"{}\" once", titles[i]));
      }
      indices[column] = i;
    }
  }
  for (const Column needed : {kClip, kStart, kLabel}) {
    if (indices[needed] != std::string_view::npos) continue;
    return lines.Error(
        fmt::format("expected a header line that names the columns, with \"clip\", \"start\" and "
                    "\"label\", found no \"{}\"",
                    kColumnTitles[needed]));
  }
  return indices;
}

// Reads a number into `value`; leaves it unset if the cell is empty.
absl::Status ReadNumber(const TabSeparated& lines, Column column, std::string_view cell,
                        std::optional<double>& value) {
  if (cell.empty()) return absl::OkStatus();
  value = ParseFiniteNumber(cell);
  if (value) return absl::OkStatus();
  return lines.Error(fmt::format("{}: expected a number, found '{}'", kColumnTitles[column],
                                 text::SafeText(cell.substr(0, 100))));
}

absl::StatusOr<Annotation> ReadRow(const TabSeparated& lines, const ColumnIndices& indices,
                                   const std::vector<std::string_view>& cells,
                                   std::string_view default_track) {
  const auto cell = [&](Column column) {
    return indices[column] == std::string_view::npos ? std::string_view() : cells[indices[column]];
  };
  Annotation annotation;
  annotation.place = lines.Place();
  annotation.clip = cell(kClip);
  annotation.label = cell(kLabel);
  annotation.track = cell(kTrack).empty() ? default_track : cell(kTrack);
  annotation.source = cell(kSource);
  std::optional<double> start;
  absl::Status status = ReadNumber(lines, kStart, cell(kStart), start);
  status.Update(ReadNumber(lines, kEnd, cell(kEnd), annotation.end_seconds));
  status.Update(ReadNumber(lines, kConfidence, cell(kConfidence), annotation.confidence));
  if (status.ok() && !start) status = lines.Error("start: expected a number, found nothing");
  if (!status.ok()) return status;
  annotation.start_seconds = *start;
  if (status = CheckAnnotation(annotation); !status.ok()) return status;
  return annotation;
}

std::string NumberText(const std::optional<double>& number) {
  return number ? fmt::format("{}", *number) : "";
}

}  // namespace

absl::StatusOr<AnnotationFile> ReadAnnotationTsv(const AnnotationSource& source) {
  TabSeparated lines(std::string(source.file_name), source.bytes);
  std::vector<std::string_view> cells;
  if (!lines.Next(cells)) {
    return absl::InvalidArgumentError(fmt::format(
        "{}:1: expected a header line with \"clip\", \"start\" and \"label\", found nothing",
        source.file_name));
  }
  const auto indices = ReadColumns(lines, cells);
  if (!indices.ok()) return indices.status();
  const std::size_t count = cells.size();
  AnnotationFile file;
  while (lines.Next(cells)) {
    const absl::Status counted = lines.CheckCellCount(count, cells.size());
    if (!counted.ok()) return counted;
    auto annotation = ReadRow(lines, *indices, cells, source.default_track);
    if (!annotation.ok()) return annotation.status();
    file.annotations.push_back(*std::move(annotation));
  }
  return file;
}

absl::StatusOr<std::string> WriteAnnotationTsv(const std::vector<Annotation>& annotations) {
  std::string text;
  for (const std::string_view title : kColumnTitles) {
    text += fmt::format("{}{}", text.empty() ? "" : "\t", title);
  }
  text += '\n';
  for (const Annotation& annotation : annotations) {
    for (const std::string& cell : {annotation.clip, annotation.label, annotation.track}) {
      if (cell.find_first_of("\t\r\n") == std::string::npos) continue;
      return absl::InvalidArgumentError(fmt::format(
          "TSV cannot contain '{}', which has a tab or line end; use JSON", text::SafeText(cell)));
    }
    if (annotation.clip.starts_with('#')) {
      return absl::InvalidArgumentError(
          fmt::format("TSV cannot contain clip '{}': its line would be a comment",
                      text::SafeText(annotation.clip)));
    }
    text += fmt::format("{}\t{}\t{}\t{}\t{}\t{}\t{}\n", annotation.clip, annotation.start_seconds,
                        NumberText(annotation.end_seconds), annotation.label, annotation.track,
                        NumberText(annotation.confidence), annotation.source);
  }
  return text;
}

}  // namespace motiondb::client
