#include "core/format/csv_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "core/format/conventions.h"
#include "core/format/text_scanner.h"
#include "core/motion/samples.h"

namespace motiondb::core {
namespace {

constexpr std::ptrdiff_t kMaxQuotedCell = 16'384;  // bytes

bool IsBlankOfCsv(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
bool IsLineEndOfCsv(char c) { return c == '\n' || c == '\r'; }

std::string_view TrimmedCell(std::string_view text) {
  while (!text.empty() && IsBlankOfCsv(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsBlankOfCsv(text.back())) text.remove_suffix(1);
  return text;
}

// Returns the most frequent separator outside of quotes in the first line; ',' if several are.
char FindSeparator(std::string_view text) {
  constexpr std::string_view kSeparators = ",;\t";
  std::array<int, kSeparators.size()> counts = {};
  bool quoted = false;
  for (const char c : text) {
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (IsLineEndOfCsv(c)) break;
    if (const auto at = kSeparators.find(c); at != kSeparators.npos) ++counts[at];
  }
  return kSeparators[std::max_element(counts.begin(), counts.end()) - counts.begin()];
}

}  // namespace

CsvRows::CsvRows(SourceFile file)
    : name_(file.name),
      begin_(file.bytes.data()),
      next_(begin_),
      end_(begin_ + file.bytes.size()),
      row_(begin_) {
  if (file.bytes.starts_with("\xEF\xBB\xBF")) next_ += 3;
  if (SkipToRow()) separator_ = FindSeparator(rest());
}

absl::StatusOr<bool> CsvRows::Next() {
  cells_.clear();
  unquoted_.clear();
  if (!SkipToRow()) return false;
  for (;;) {
    if (cells_.size() == kMaxTableColumns) {
      return Error("expected at most {} cells in a line", kMaxTableColumns);
    }
    MOTIONDB_RETURN_IF_ERROR(TakeCell());
    if (next_ == end_ || IsLineEndOfCsv(*next_)) break;
    ++next_;
  }
  PassLineEnd();
  return true;
}

// Passes blank lines and comments; false at the end of the file.
bool CsvRows::SkipToRow() {
  while (next_ < end_) {
    row_ = next_;
    const char* at = next_;
    while (at < end_ && IsBlankOfCsv(*at)) ++at;
    if (at < end_ && !IsLineEndOfCsv(*at) && *at != '#') return true;
    next_ = std::find_if(at, end_, IsLineEndOfCsv);
    PassLineEnd();
  }
  row_ = end_;
  return false;
}

void CsvRows::PassLineEnd() {
  if (next_ == end_) return;
  next_ += *next_ == '\r' && next_ + 1 < end_ && next_[1] == '\n' ? 2 : 1;
}

bool CsvRows::AtCellEnd() const {
  return next_ == end_ || *next_ == separator_ || IsLineEndOfCsv(*next_);
}

absl::Status CsvRows::TakeCell() {
  while (!AtCellEnd() && IsBlankOfCsv(*next_)) ++next_;
  if (next_ < end_ && *next_ == '"') return TakeQuotedCell();
  const char* const first = next_;
  while (!AtCellEnd()) ++next_;
  cells_.push_back(TrimmedCell({first, static_cast<std::size_t>(next_ - first)}));
  return absl::OkStatus();
}

absl::Status CsvRows::TakeQuotedCell() {
  const char* const first = ++next_;
  const char* const limit = end_ - next_ > kMaxQuotedCell ? next_ + kMaxQuotedCell : end_;
  bool doubled = false;
  for (;;) {
    next_ = std::find(next_, limit, '"');
    if (next_ == limit) {
      return Error("expected a closing quote within {} bytes after '{}'", kMaxQuotedCell,
                   Shown({first, static_cast<std::size_t>(limit - first)}));
    }
    if (next_ + 1 == end_ || next_[1] != '"') break;
    doubled = true;
    next_ += limit - next_ > 2 ? 2 : limit - next_;
  }
  std::string_view cell(first, static_cast<std::size_t>(next_ - first));
  if (doubled) {
    std::string& text = unquoted_.emplace_back();
    for (std::size_t i = 0; i < cell.size(); ++i) {
      text += cell[i];
      if (cell[i] == '"') ++i;
    }
    cell = text;
  }
  cells_.push_back(TrimmedCell(cell));
  const char* const after = ++next_;
  while (!AtCellEnd() && IsBlankOfCsv(*next_)) ++next_;
  if (AtCellEnd()) return absl::OkStatus();
  const std::string_view tail(after, static_cast<std::size_t>(end_ - after));
  return Error("expected the end of the cell after its closing quote, found '{}'",
               Shown(tail.substr(0, tail.find_first_of("\r\n"))));
}

int CsvRows::Line() const {
  int line = 1;
  for (const char* p = begin_; p < row_; ++p) {
    if (*p == '\n' || (*p == '\r' && (p + 1 == end_ || p[1] != '\n'))) ++line;
  }
  return line;
}

int LineOfRow(SourceFile file, std::int64_t row) {
  CsvRows rows(file);
  for (std::int64_t i = 0; i <= row; ++i) {
    const auto more = rows.Next();
    if (!more.ok() || !*more) break;
  }
  return rows.Line();
}

CsvSize MaxCsvSize(std::string_view text) {
  CsvSize size = {.rows = 1, .cells = 1};
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool line_end = c == '\n' || (c == '\r' && !text.substr(i + 1).starts_with('\n'));
    size.rows += line_end ? 1 : 0;
    size.cells += line_end || c == ',' || c == ';' || c == '\t' ? 1 : 0;
  }
  return size;
}

absl::StatusOr<JointMatrix> ReadNumberRows(CsvRows& rows, std::span<const std::string> columns,
                                           EmptyCells empty, bool from_current) {
  const auto width = std::ssize(columns);
  // Each row has `width` cells: this bounds the allocation.
  const CsvSize size = MaxCsvSize(rows.rest());
  const std::int64_t max_rows = std::min(size.rows, size.cells / width) + (from_current ? 1 : 0);
  if (max_rows > std::numeric_limits<int>::max()) {
    return rows.Error("expected at most {} rows", std::numeric_limits<int>::max());
  }
  JointMatrix values(max_rows, width);
  std::int64_t count = 0;
  for (bool current = from_current;; current = false) {
    if (!current) {
      MOTIONDB_ASSIGN_OR_RETURN(const bool more, rows.Next());
      if (!more) break;
    }
    if (std::ssize(rows.cells()) == width + 1 && rows.cells().back().empty()) rows.DropLastCell();
    if (std::ssize(rows.cells()) != width) {
      return rows.Error("expected {} numbers, found {} cells", width, rows.cells().size());
    }
    double* value = values.data() + count * width;
    for (std::ptrdiff_t c = 0; c < width; ++c, ++value) {
      const std::string_view cell = rows.cells()[c];
      if (const std::optional<double> number = ParseNumber(cell)) {
        *value = *number;
      } else if (empty == EmptyCells::kMissing && (cell.empty() || IsKeyword(cell, "nan"))) {
        *value = std::numeric_limits<double>::quiet_NaN();
      } else {
        return rows.Error("expected a number in column {} ('{}'), found {}", c + 1,
                          Shown(columns[c]),
                          cell.empty() ? "an empty cell" : fmt::format("'{}'", Shown(cell)));
      }
    }
    ++count;
  }
  if (count == 0) return rows.Error("the file ends here (truncated?), expected a row of numbers");
  values.conservativeResize(count, width);
  return values;
}

namespace {

// Half of the last decimal place (s) of numbers that were rounded, for example 5e-4 for 0.033.
double RoundingOf(const Eigen::VectorXd& times_s) {
  constexpr double kSame = 1e-6;  // of a place
  double place = 1;
  for (const double time : times_s) {
    while (place > 1e-9 && std::abs(time / place - std::round(time / place)) > kSame) place /= 10;
  }
  return place / 2;
}

}  // namespace

absl::StatusOr<double> FrameRateOfTimes(SourceFile file, const Eigen::VectorXd& times_s,
                                        std::int64_t first_row, std::vector<std::string>& notes) {
  constexpr double kMaxDifference = 0.01;
  constexpr double kMaxRounding = 0.5;  // less than a missing row
  const auto error = [&](Eigen::Index at, std::string_view expected) {
    return InvalidArgument("{}:{}: expected {}, found {} s after {} s", file.name,
                           LineOfRow(file, first_row + at), expected, times_s[at], times_s[at - 1]);
  };
  const Eigen::Index count = times_s.size();
  std::vector<double> steps;
  steps.reserve(static_cast<std::size_t>(count - 1));
  for (Eigen::Index i = 1; i < count; ++i) {
    if (!(times_s[i] > times_s[i - 1])) return error(i, "times that increase");
    steps.push_back(times_s[i] - times_s[i - 1]);
  }
  // The median, so that the error is at the gap.
  const double usual = Quantile(steps, 0.5);
  const double tolerance =
      kMaxDifference * usual + std::min(2 * RoundingOf(times_s), kMaxRounding * usual);
  for (Eigen::Index i = 1; i < count; ++i) {
    if (std::abs(times_s[i] - times_s[i - 1] - usual) <= tolerance) continue;
    return error(i, fmt::format("times in steps of {:.6g} s", usual));
  }
  const double rate_hz = static_cast<double>(count - 1) / (times_s[count - 1] - times_s[0]);
  if (!IsFrameRate(rate_hz)) return error(1, "a frame rate from 0.001 to 100000 Hz");
  return SnapFrameRate(rate_hz, notes);
}

}  // namespace motiondb::core
