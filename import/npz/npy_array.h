// One array in the .npy format of NumPy: numbers or texts in any shape.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::importer {

// Type, shape and layout of an array, from its header.
struct NpyHeader {
  enum class Kind { kBoolean, kSigned, kUnsigned, kReal, kUtf32Text, kByteText };
  Kind kind = Kind::kReal;
  std::size_t item_bytes = 8;
  bool big_endian = false;
  bool fortran_order = false;      // the first index is the fastest
  std::vector<std::size_t> shape;  // empty: one value
  std::size_t count = 1;           // of values: the product of the shape
  std::size_t data_offset = 0;     // of the first value in the member
  std::size_t data_bytes() const { return count * item_bytes; }
};

inline constexpr std::size_t kMaxNpyHeader = 65536;  // bytes of a member before its first value

// Parses the header at the start of a member, versions 1 to 3. `bytes` may end after kMaxNpyHeader
// bytes. INVALID_ARGUMENT, beginning with "byte N: ", for anything but booleans, integers, reals of
// 2, 4 or 8 bytes and texts, for more than 32 dimensions, and for a size that does not fit 64 bits.
// Object arrays are rejected: they are pickles, which are programs.
absl::StatusOr<NpyHeader> ParseNpyHeader(std::string_view bytes);

// Immutable.
class NpyArray {
 public:
  // REQUIRES: `member` has all bytes of the header and its data.
  NpyArray(NpyHeader header, std::string member);

  std::span<const std::size_t> shape() const { return header_.shape; }
  std::size_t size() const { return header_.count; }
  bool is_text() const;

  // Returns the value with this index in C order (the last index of the shape is the fastest). A
  // boolean is 0 or 1; a 64-bit integer is rounded to double. REQUIRES: index < size(), not
  // is_text().
  double Number(std::size_t index) const;
  // Returns the text as UTF-8; bytes that are not UTF-8 are Latin-1. REQUIRES: index < size(),
  // is_text().
  std::string Text(std::size_t index) const;

 private:
  std::string_view Item(std::size_t index) const;

  NpyHeader header_;
  std::string member_;
};

// Returns "(300, 156)".
std::string ShapeText(std::span<const std::size_t> shape);

}  // namespace motiondb::importer
