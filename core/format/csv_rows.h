// Reads the rows of a text table (CSV as in RFC 4180) from a file in memory. Cells are separated by
// ',', ';' or tabs: the one that is most frequent in the first row. Lines end in LF, CRLF or CR; a
// UTF-8 byte order mark, blank lines and lines that begin with '#' are skipped. Numbers have a
// decimal point.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "core/motion/error.h"
#include "core/motion/matrix.h"

namespace motiondb::core {

// Time and 65,535 points, as many as in C3D.
inline constexpr int kMaxTableColumns = 1 + 3 * 65'535;

// Thread-compatible. The caller keeps the file's bytes.
class CsvRows {
 public:
  explicit CsvRows(SourceFile file);

  // Reads the next row. Returns false at the end of the file.
  absl::StatusOr<bool> Next();
  // The cells of the last row read: without quotes, trimmed, valid until the next call of Next().
  std::span<const std::string_view> cells() const { return cells_; }
  // Removes the last cell.
  void DropLastCell() { cells_.pop_back(); }

  std::string_view rest() const { return {next_, static_cast<std::size_t>(end_ - next_)}; }
  // Line of the last row read, from 1. O(file), for errors only.
  int Line() const;
  // Returns an error at the line of the last row read.
  template <typename... Args>
  absl::Status Error(fmt::format_string<Args...> format, Args&&... args) const {
    return InvalidArgument("{}:{}: {}", name_, Line(),
                           fmt::format(format, std::forward<Args>(args)...));
  }

 private:
  bool SkipToRow();
  absl::Status TakeCell();
  absl::Status TakeQuotedCell();
  void PassLineEnd();
  bool AtCellEnd() const;

  std::string_view name_;
  char separator_ = ',';
  const char* begin_;
  const char* next_;
  const char* end_;
  const char* row_;  // start of the last row read
  std::vector<std::string_view> cells_;
  std::deque<std::string> unquoted_;  // cells of this row that had doubled quotes
};

// Line of the row with this index, counted from 0. O(file), for errors only.
int LineOfRow(SourceFile file, std::int64_t row);

// Upper bounds for the rows of a table and for its cells, with any separator. O(text).
struct CsvSize {
  std::int64_t rows = 0;
  std::int64_t cells = 0;
};
CsvSize MaxCsvSize(std::string_view text);

enum class EmptyCells { kMissing, kError };

// Reads the numbers of the rest of a table, rows x columns.size(). kMissing: an empty cell or "nan"
// is NaN. One empty cell after the last column is ignored. `from_current`: the row that was read
// last is the first one. `columns` are names for errors.
absl::StatusOr<JointMatrix> ReadNumberRows(CsvRows& rows, std::span<const std::string> columns,
                                           EmptyCells empty, bool from_current);

// Returns the frame rate (Hz) of a table's column of times (s), see SnapFrameRate. The times
// increase, and their steps differ by at most 1 % and the precision of the numbers, otherwise the
// error names the first line of `file` that does not. `first_row`: index of the row of times[0].
absl::StatusOr<double> FrameRateOfTimes(SourceFile file, const Eigen::VectorXd& times_s,
                                        std::int64_t first_row, std::vector<std::string>& notes);

}  // namespace motiondb::core
