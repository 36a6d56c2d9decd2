#include "import/npz/npy_array.h"

#include <fmt/format.h>

#include <bit>
#include <cassert>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>

#include "core/format/text_scanner.h"
#include "core/motion/error.h"
#include "text/utf8.h"

namespace motiondb::importer {
namespace {

constexpr std::string_view kNpyMagic = "\x93NUMPY";
constexpr std::size_t kMaxDimensions = 32;  // as in NumPy
constexpr std::size_t kMaxTextLength = 1'000'000;

std::uint64_t NpyInteger(std::string_view bytes, bool big_endian) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const char byte = bytes[big_endian ? i : bytes.size() - 1 - i];
    value = value << 8 | static_cast<unsigned char>(byte);
  }
  return value;
}

double HalfToDouble(std::uint64_t bits) {
  const auto exponent = static_cast<int>(bits >> 10 & 0x1f);
  const auto fraction = static_cast<double>(bits & 0x3ff);
  double value = 0;
  if (exponent == 0x1f) {
    value = fraction == 0 ? std::numeric_limits<double>::infinity()
                          : std::numeric_limits<double>::quiet_NaN();
  } else if (exponent == 0) {
    value = std::ldexp(fraction, -24);
  } else {
    value = std::ldexp(fraction + 1024, exponent - 25);
  }
  return (bits & 0x8000) != 0 ? -value : value;
}

// Parses the dictionary of a header, a Python literal such as
// {'descr': '<f8', 'fortran_order': False, 'shape': (300, 156), }
class NpyHeaderParser {
 public:
  // `begin`: offset of the dictionary in `bytes`, which end with it.
  NpyHeaderParser(std::string_view bytes, std::size_t begin) : bytes_(bytes), at_(begin) {}

  absl::StatusOr<NpyHeader> Parse() {
    MOTIONDB_RETURN_IF_ERROR(Expect('{'));
    while (!Accept('}')) {
      MOTIONDB_RETURN_IF_ERROR(ParseEntry());
      if (Accept(',')) continue;
      MOTIONDB_RETURN_IF_ERROR(Expect('}'));
      break;
    }
    SkipBlanks();
    if (at_ != bytes_.size()) return Expected("the end of the header");
    if (!has_type_ || !has_order_ || !has_shape_) {
      return Expected("the keys descr, fortran_order and shape");
    }
    MOTIONDB_RETURN_IF_ERROR(CheckSize());
    header_.data_offset = bytes_.size();
    return std::move(header_);
  }

 private:
  absl::Status ParseEntry() {
    MOTIONDB_ASSIGN_OR_RETURN(const std::string_view key, ParseText());
    MOTIONDB_RETURN_IF_ERROR(Expect(':'));
    SkipBlanks();
    if (key == "descr" && !std::exchange(has_type_, true)) return ParseType();
    if (key == "fortran_order" && !std::exchange(has_order_, true)) return ParseOrder();
    if (key == "shape" && !std::exchange(has_shape_, true)) return ParseShape();
    return core::InvalidArgument("byte {}: unexpected or repeated key '{}'", at_, core::Shown(key));
  }

  absl::Status ParseType() {
    if (at_ < bytes_.size() && bytes_[at_] == '[') {
      return core::InvalidArgument(
          "byte {}: the array has a structured type (named fields); expected numbers or texts",
          at_);
    }
    const std::size_t begin = at_;
    MOTIONDB_ASSIGN_OR_RETURN(const std::string_view type, ParseText());
    if (type.find('O') != std::string_view::npos) {
      return core::InvalidArgument(
          "byte {}: an object array (a pickle) is not read, because a pickle is a program; save "
          "the values as an array of numbers or texts",
          begin);
    }
    if (!SetType(type)) {
      return core::InvalidArgument(
          "byte {}: the type '{}' is not read; expected b1, i1 to i8, u1 to u8, f2, f4, f8, U or S",
          begin, core::Shown(type));
    }
    return absl::OkStatus();
  }

  // Returns whether the type, such as "<f8", is supported.
  bool SetType(std::string_view type) {
    if (type.size() < 2) return false;
    const char order = type[0];
    const bool ordered = order == '<' || order == '>';
    if (!ordered && order != '|') return false;
    header_.big_endian = order == '>';
    std::size_t size = 0;
    const char* end = type.data() + type.size();
    const auto [rest, error] = std::from_chars(type.data() + 2, end, size);
    if (error != std::errc() || rest != end || size == 0 || size > kMaxTextLength) return false;
    using enum NpyHeader::Kind;
    header_.item_bytes = size;
    const bool is_word = size == 1 || (ordered && (size == 2 || size == 4 || size == 8));
    switch (type[1]) {
      case 'b':
        header_.kind = kBoolean;
        return size == 1;
      case 'i':
        header_.kind = kSigned;
        return is_word;
      case 'u':
        header_.kind = kUnsigned;
        return is_word;
      case 'f':
        header_.kind = kReal;
        return is_word && size > 1;
      case 'S':
        header_.kind = kByteText;
        return true;
      case 'U':
        header_.kind = kUtf32Text;
        header_.item_bytes = 4 * size;
        return ordered;
      default:
        return false;
    }
  }

  absl::Status ParseOrder() {
    for (const bool fortran : {true, false}) {
      const std::string_view word = fortran ? "True" : "False";
      if (!bytes_.substr(at_).starts_with(word)) continue;
      header_.fortran_order = fortran;
      at_ += word.size();
      return absl::OkStatus();
    }
    return Expected("True or False");
  }

  absl::Status ParseShape() {
    MOTIONDB_RETURN_IF_ERROR(Expect('('));
    while (!Accept(')')) {
      if (header_.shape.size() == kMaxDimensions) {
        return Expected(fmt::format("at most {} dimensions", kMaxDimensions));
      }
      SkipBlanks();
      std::size_t size = 0;
      const char* begin = bytes_.data() + at_;
      const auto [end, error] = std::from_chars(begin, bytes_.data() + bytes_.size(), size);
      if (error != std::errc()) return Expected("a size from 0 to 2^64 - 1");
      at_ += static_cast<std::size_t>(end - begin);
      if (at_ < bytes_.size() && bytes_[at_] == 'L') ++at_;  // written by Python 2
      header_.shape.push_back(size);
      if (Accept(',')) continue;
      MOTIONDB_RETURN_IF_ERROR(Expect(')'));
      break;
    }
    return absl::OkStatus();
  }

  absl::Status CheckSize() {
    std::size_t nonzero = header_.item_bytes;
    header_.count = 1;
    for (const std::size_t size : header_.shape) {
      header_.count = size == 0 ? 0 : header_.count * size;
      if (size == 0) continue;
      if (nonzero > std::numeric_limits<std::ptrdiff_t>::max() / size) {
        return core::InvalidArgument("byte {}: the shape {} does not fit 64 bits", at_,
                                     ShapeText(header_.shape));
      }
      nonzero *= size;
    }
    return absl::OkStatus();
  }

  absl::StatusOr<std::string_view> ParseText() {
    SkipBlanks();
    if (at_ == bytes_.size() || (bytes_[at_] != '\'' && bytes_[at_] != '"')) {
      return Expected("a text in quotes");
    }
    const std::size_t begin = at_ + 1;
    const std::size_t end = bytes_.find(bytes_[at_], begin);
    if (end == std::string_view::npos) return Expected("a text that ends with its quote");
    at_ = end + 1;
    return bytes_.substr(begin, end - begin);
  }

  void SkipBlanks() {
    while (at_ < bytes_.size() && (bytes_[at_] == ' ' || bytes_[at_] == '\n')) ++at_;
  }

  bool Accept(char token) {
    SkipBlanks();
    if (at_ == bytes_.size() || bytes_[at_] != token) return false;
    ++at_;
    return true;
  }

  absl::Status Expect(char token) {
    return Accept(token) ? absl::OkStatus() : Expected(fmt::format("'{}'", token));
  }

  absl::Status Expected(std::string_view what) const {
    if (at_ == bytes_.size()) {
      return core::InvalidArgument("byte {}: the header ends, expected {}", at_, what);
    }
    return core::InvalidArgument("byte {}: expected {}, found '{}'", at_, what,
                                 core::Shown(bytes_.substr(at_)));
  }

  std::string_view bytes_;
  std::size_t at_;
  NpyHeader header_;
  bool has_type_ = false;
  bool has_order_ = false;
  bool has_shape_ = false;
};

}  // namespace

absl::StatusOr<NpyHeader> ParseNpyHeader(std::string_view bytes) {
  constexpr std::size_t kVersionAt = kNpyMagic.size();
  constexpr std::size_t kLengthAt = kVersionAt + 2;
  if (!bytes.starts_with(kNpyMagic)) {
    return core::InvalidArgument("byte 0: expected a NumPy array (\\x93NUMPY), found '{}'",
                                 core::Shown(bytes.substr(0, kNpyMagic.size())));
  }
  const int version = bytes.size() > kVersionAt ? static_cast<unsigned char>(bytes[kVersionAt]) : 1;
  if (version < 1 || version > 3) {
    return core::InvalidArgument("byte {}: expected version 1, 2 or 3, found {}", kVersionAt,
                                 version);
  }
  const std::size_t length_bytes = version == 1 ? 2 : 4;
  const std::size_t begin = kLengthAt + length_bytes;
  if (bytes.size() < begin) {
    return core::InvalidArgument("byte {}: the array ends in its header", bytes.size());
  }
  const std::uint64_t length = NpyInteger(bytes.substr(kLengthAt, length_bytes), false);
  if (begin + length > kMaxNpyHeader) {
    return core::InvalidArgument("byte {}: expected a header of at most {} bytes, found {}",
                                 kLengthAt, kMaxNpyHeader - begin, length);
  }
  if (bytes.size() < begin + length) {
    return core::InvalidArgument("byte {}: the array ends in its header of {} bytes", bytes.size(),
                                 length);
  }
  return NpyHeaderParser(bytes.substr(0, begin + length), begin).Parse();
}

NpyArray::NpyArray(NpyHeader header, std::string member)
    : header_(std::move(header)), member_(std::move(member)) {
  assert(member_.size() >= header_.data_offset + header_.data_bytes());
}

bool NpyArray::is_text() const {
  return header_.kind == NpyHeader::Kind::kUtf32Text || header_.kind == NpyHeader::Kind::kByteText;
}

std::string_view NpyArray::Item(std::size_t index) const {
  assert(index < header_.count);
  std::size_t at = index;
  if (header_.fortran_order) {
    at = 0;
    std::size_t stride = header_.count;
    for (std::size_t d = header_.shape.size(); d-- > 0;) {
      stride /= header_.shape[d];
      at += index % header_.shape[d] * stride;
      index /= header_.shape[d];
    }
  }
  return std::string_view(member_).substr(header_.data_offset + at * header_.item_bytes,
                                          header_.item_bytes);
}

double NpyArray::Number(std::size_t index) const {
  assert(!is_text());
  const std::string_view item = Item(index);
  const std::uint64_t bits = NpyInteger(item, header_.big_endian);
  switch (header_.kind) {
    case NpyHeader::Kind::kBoolean:
      return bits != 0 ? 1 : 0;
    case NpyHeader::Kind::kUnsigned:
      return static_cast<double>(bits);
    case NpyHeader::Kind::kSigned: {
      const auto unused = static_cast<int>(64 - 8 * item.size());
      return static_cast<double>(std::bit_cast<std::int64_t>(bits << unused) >> unused);
    }
    case NpyHeader::Kind::kReal:
      if (item.size() == 2) return HalfToDouble(bits);
      if (item.size() == 4) return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
      return std::bit_cast<double>(bits);
    case NpyHeader::Kind::kUtf32Text:
    case NpyHeader::Kind::kByteText:
      break;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

std::string NpyArray::Text(std::size_t index) const {
  assert(is_text());
  std::string_view item = Item(index);
  if (header_.kind == NpyHeader::Kind::kByteText) {
    while (item.ends_with('\0')) item.remove_suffix(1);
    return core::ToUtf8(item);
  }
  std::string text;
  for (; !item.empty(); item.remove_prefix(4)) {
    const std::uint64_t code = NpyInteger(item.substr(0, 4), header_.big_endian);
    const bool is_character = code < 0xd800 || (code >= 0xe000 && code <= 0x10ffff);
    text::AppendUtf8(is_character ? static_cast<char32_t>(code) : U'?', text);
  }
  while (text.ends_with('\0')) text.pop_back();
  return core::ToUtf8(text);
}

std::string ShapeText(std::span<const std::size_t> shape) {
  std::string text = "(";
  for (const std::size_t size : shape) {
    if (text.size() > 1) text += ", ";
    text += fmt::format("{}", size);
  }
  return text + ")";
}

}  // namespace motiondb::importer
