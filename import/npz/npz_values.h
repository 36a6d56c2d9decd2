// Checked values of the arrays of a NumPy archive. Errors are INVALID_ARGUMENT and begin with file
// and array.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "import/npz/npy_array.h"
#include "import/npz/npz_archive.h"

namespace motiondb::importer {

// An open archive with what its readers need.
struct NpzSource {
  NpzArchive& archive;
  std::string_view file_name;
  std::size_t max_bytes;
};

// An array as a table: its first dimension are the rows, all others together the columns.
class NpzTable {
 public:
  NpzTable(std::string name, NpyArray array);

  const std::string& name() const { return name_; }
  std::size_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }
  // REQUIRES: row < rows(), column < columns().
  double at(std::size_t row, std::size_t column) const {
    return array_.Number(row * columns_ + column);
  }

 private:
  std::string name_;
  NpyArray array_;
  std::size_t rows_ = 0;
  std::size_t columns_ = 0;
};

// Whether a table may have NaN.
enum class Gaps { kAllowed, kRejected };

// Reads an array of numbers with at least two dimensions. All must be finite, or NaN where allowed,
// and at most 1e18 in magnitude, whose square still fits a float. An error names row and column.
// `expected_columns`: empty for any number.
absl::StatusOr<NpzTable> ReadTable(NpzArchive& archive, std::string_view file_name,
                                   std::string_view name,
                                   std::initializer_list<std::size_t> expected_columns,
                                   Gaps gaps = Gaps::kRejected);

// Returns INVALID_ARGUMENT if the table does not have as many rows as `rows_of` has.
absl::Status CheckSameRows(std::string_view file_name, const NpzTable& table,
                           const NpzTable& rows_of);

// Returns INVALID_ARGUMENT if a motion of this size exceeds source.max_bytes: a few bytes of a file
// can become many of a motion. O(1).
absl::Status CheckMotionSize(const NpzSource& source, std::size_t frames,
                             std::size_t bytes_per_frame);

// Reads a single number, of shape () or (1).
absl::StatusOr<double> ReadScalar(NpzArchive& archive, std::string_view file_name,
                                  std::string_view name);

// Reads the texts of an array with one dimension.
absl::StatusOr<std::vector<std::string>> ReadTexts(NpzArchive& archive, std::string_view file_name,
                                                   std::string_view name);

// Reads a single text, of shape () or (1). Nothing if there is none that can be read.
std::optional<std::string> TryText(NpzArchive& archive, std::string_view name);

// Returns the names of the archive's arrays for an error: "poses, trans, betas".
std::string ArrayList(const NpzArchive& archive);

}  // namespace motiondb::importer
