#include "import/npz/npz_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/format/text_scanner.h"
#include "core/motion/error.h"
#include "import/npz/npz_archive.h"

namespace motiondb::importer {
namespace {

constexpr double kMaxNpzNumber = 1e18;

std::string ColumnsText(std::initializer_list<std::size_t> columns) {
  std::string text;
  for (const std::size_t count : columns) {
    if (!text.empty()) text += " or ";
    text += fmt::format("{}", count);
  }
  return text;
}

absl::Status CheckNumbers(std::string_view file_name, const NpzTable& table, Gaps gaps) {
  for (std::size_t row = 0; row < table.rows(); ++row) {
    for (std::size_t column = 0; column < table.columns(); ++column) {
      const double value = table.at(row, column);
      if (std::abs(value) <= kMaxNpzNumber) continue;
      if (std::isnan(value) && gaps == Gaps::kAllowed) continue;
      return core::InvalidArgument(
          "{}: array '{}': frame {}, column {}: expected a finite number, found {}", file_name,
          table.name(), row, column, value);
    }
  }
  return absl::OkStatus();
}

}  // namespace

NpzTable::NpzTable(std::string name, NpyArray array)
    : name_(std::move(name)), array_(std::move(array)) {
  rows_ = array_.shape().empty() ? 1 : array_.shape().front();
  columns_ = rows_ == 0 ? 0 : array_.size() / rows_;
}

absl::StatusOr<NpzTable> ReadTable(NpzArchive& archive, std::string_view file_name,
                                   std::string_view name,
                                   std::initializer_list<std::size_t> expected_columns, Gaps gaps) {
  MOTIONDB_ASSIGN_OR_RETURN(NpyArray array, archive.Read(name));
  if (array.is_text()) {
    return core::InvalidArgument("{}: array '{}': expected numbers, found texts", file_name, name);
  }
  const std::string shape = ShapeText(array.shape());
  const bool is_table = array.shape().size() >= 2 && array.size() > 0;
  NpzTable table(std::string(name), std::move(array));
  const bool expected =
      expected_columns.size() == 0 || std::find(expected_columns.begin(), expected_columns.end(),
                                                table.columns()) != expected_columns.end();
  if (!is_table || !expected) {
    return core::InvalidArgument(
        "{}: array '{}': expected at least one frame of {} numbers, found the shape {}", file_name,
        name, expected_columns.size() == 0 ? "any" : ColumnsText(expected_columns), shape);
  }
  MOTIONDB_RETURN_IF_ERROR(CheckNumbers(file_name, table, gaps));
  return table;
}

absl::Status CheckSameRows(std::string_view file_name, const NpzTable& table,
                           const NpzTable& rows_of) {
  if (table.rows() == rows_of.rows()) return absl::OkStatus();
  return core::InvalidArgument("{}: array '{}': expected {} frames, as '{}' has, found {}",
                               file_name, table.name(), rows_of.rows(), rows_of.name(),
                               table.rows());
}

absl::Status CheckMotionSize(const NpzSource& source, std::size_t frames,
                             std::size_t bytes_per_frame) {
  if (frames <= std::numeric_limits<int>::max() && frames <= source.max_bytes / bytes_per_frame) {
    return absl::OkStatus();
  }
  return core::InvalidArgument("{}: the motion of {} frames exceeds the limit of {} bytes",
                               source.file_name, frames, source.max_bytes);
}

absl::StatusOr<double> ReadScalar(NpzArchive& archive, std::string_view file_name,
                                  std::string_view name) {
  MOTIONDB_ASSIGN_OR_RETURN(const NpyArray array, archive.Read(name));
  if (array.is_text() || array.size() != 1) {
    return core::InvalidArgument("{}: array '{}': expected one number, found {} of the shape {}",
                                 file_name, name, array.is_text() ? "texts" : "numbers",
                                 ShapeText(array.shape()));
  }
  return array.Number(0);
}

absl::StatusOr<std::vector<std::string>> ReadTexts(NpzArchive& archive, std::string_view file_name,
                                                   std::string_view name) {
  MOTIONDB_ASSIGN_OR_RETURN(const NpyArray array, archive.Read(name));
  if (!array.is_text() || array.shape().size() != 1) {
    return core::InvalidArgument("{}: array '{}': expected a list of texts, found {} of shape {}",
                                 file_name, name, array.is_text() ? "texts" : "numbers",
                                 ShapeText(array.shape()));
  }
  std::vector<std::string> texts;
  texts.reserve(array.size());
  for (std::size_t i = 0; i < array.size(); ++i) texts.push_back(array.Text(i));
  return texts;
}

std::optional<std::string> TryText(NpzArchive& archive, std::string_view name) {
  const auto array = archive.Read(name);
  if (!array.ok() || !array->is_text() || array->size() != 1) return std::nullopt;
  return array->Text(0);
}

std::string ArrayList(const NpzArchive& archive) {
  constexpr std::size_t kMaxListed = 20;
  const std::vector<std::string> names = archive.names();
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMaxListed); ++i) {
    text += (i > 0 ? ", " : "") + core::Shown(names[i]);
  }
  if (names.size() > kMaxListed) text += fmt::format(" and {} more", names.size() - kMaxListed);
  return text.empty() ? "no array" : text;
}

absl::StatusOr<core::MotionFile> ReadNpz(core::SourceFile file, const core::ReadOptions& options,
                                         std::size_t max_bytes) {
  MOTIONDB_ASSIGN_OR_RETURN(NpzArchive archive, NpzArchive::Open(file, max_bytes));
  const NpzSource source{.archive = archive, .file_name = file.name, .max_bytes = max_bytes};
  if (archive.Has("motiondb_version")) return ReadMotiondbNpz(source, options);
  if (IsSmpl(archive)) return ReadSmpl(source, options);
  return core::InvalidArgument(
      "{}: expected the arrays of AMASS or SMPL (poses, trans), AIST++ (smpl_poses, smpl_trans) or "
      "motiondb (motiondb_version); found {}",
      file.name, ArrayList(archive));
}

}  // namespace motiondb::importer
