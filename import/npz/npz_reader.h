// Reads human motion from NumPy archives (.npz).
#pragma once

#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "import/npz/npy_array.h"
#include "import/npz/npz_archive.h"

namespace motiondb::importer {

// Recognizes, by the arrays of the archive (F: frames; rotations are axis-angle vectors in radians,
// translations metres):
//   motiondb     motiondb_version ...: the layout of core/export/writers.h
//   AMASS        poses (F, 156 SMPL-H or 165 SMPL-X), or root_orient (F, 3), pose_body (F, 63),
//                pose_hand (F, 90), pose_jaw (F, 3), pose_eye (F, 6); trans (F, 3);
//                mocap_framerate or mocap_frame_rate; gender; surface_model_type. z up.
//   SMPL family  poses (F, 66, 72, 156 or 165), or the arrays of AMASS; trans; fps. Up axis:
//                deduced from the motion, or y.
//   AIST++       smpl_poses (F, 72), smpl_trans (F, 3) divided by smpl_scaling. Up axis: deduced,
//                or y.
// Rotations may also have the shape (F, joints, 3). Ignores all other arrays.
//
// The SMPL family has a mean body (import/npz/smpl_body.h), which a note reports; `betas`, the
// shape of the subject, needs the licensed model and is ignored with a note. The pelvis is at trans
// + SmplPelvis. Joints without rotations in the file do not move.
//
// Frame rate: `options`, or the file. Without both, SMPL is assumed to have 30 Hz and AIST++ 60 Hz,
// with a note; SMPL-H and SMPL-X are rejected, because AMASS always states it. A unit in `options`
// applies to translations.
//
// `max_bytes`: limit of the decompressed arrays that are read, and of the resulting motion.
// INVALID_ARGUMENT names file and array, and for numbers frame and column, from 0. Errors about
// missing arrays list those that are there.
absl::StatusOr<core::MotionFile> ReadNpz(core::SourceFile file, const core::ReadOptions& options,
                                         std::size_t max_bytes);

// The parts of ReadNpz. Values of arrays are checked: errors are INVALID_ARGUMENT and begin with
// file and array.

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

// Whether the archive has arrays of rotations of a body model.
bool IsSmpl(const NpzArchive& archive);

// See ReadNpz. REQUIRES: IsSmpl.
absl::StatusOr<core::MotionFile> ReadSmpl(const NpzSource& source,
                                          const core::ReadOptions& options);

// Reads motiondb's own layout. Joints get three rotations each, and three translations where their
// local positions change. `rest_rotations` may be absent: no rotation. Ignores the world positions
// of joints, which follow from the local ones. Errors: see ReadNpz.
absl::StatusOr<core::MotionFile> ReadMotiondbNpz(const NpzSource& source,
                                                 const core::ReadOptions& options);

}  // namespace motiondb::importer
