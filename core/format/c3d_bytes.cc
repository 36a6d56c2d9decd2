#include "core/format/c3d_bytes.h"

#include <bit>

namespace motiondb::core {

absl::Status C3dBytes::Require(std::size_t offset, std::size_t count, std::string_view what) const {
  if (offset <= size() && count <= size() - offset) return absl::OkStatus();
  return Error(offset, "expected {} bytes of {}, the file has only {} bytes (truncated?)", count,
               what, size());
}

std::uint8_t C3dBytes::Byte(std::size_t offset) const {
  return static_cast<std::uint8_t>(file_.bytes[offset]);
}

std::uint16_t C3dBytes::Word(std::size_t offset) const {
  const int first = Byte(offset);
  const int second = Byte(offset + 1);
  return static_cast<std::uint16_t>(processor_ == C3dProcessor::kMips ? (first << 8) | second
                                                                      : (second << 8) | first);
}

std::int16_t C3dBytes::SignedWord(std::size_t offset) const {
  return static_cast<std::int16_t>(Word(offset));
}

float C3dBytes::Real(std::size_t offset) const {
  const std::uint32_t first = Word(offset);
  const std::uint32_t second = Word(offset + 2);
  if (processor_ == C3dProcessor::kIntel) return std::bit_cast<float>((second << 16) | first);
  const float value = std::bit_cast<float>((first << 16) | second);
  // The VAX has IEEE's bits with the words swapped, and counts its exponent from two higher.
  return processor_ == C3dProcessor::kDec ? value / 4 : value;
}

std::string_view C3dBytes::Text(std::size_t offset, std::size_t count) const {
  return file_.bytes.substr(offset, count);
}

}  // namespace motiondb::core
