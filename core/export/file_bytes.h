// Appends to the bytes of a file: memory for text that grows by a line for each frame, and numbers
// with the least significant byte first.
#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>

namespace motiondb::core {

// Reserves memory for `frames_left` further frames, each somewhat longer than `frame_bytes`. A text
// that doubles its memory instead needs up to three times its size.
inline void ReserveFrames(std::string& text, std::size_t frame_bytes, Eigen::Index frames_left) {
  const std::size_t with_margin = frame_bytes + frame_bytes / 10;
  text.reserve(text.size() + with_margin * static_cast<std::size_t>(frames_left));
}

inline void AppendWord16(std::uint16_t value, std::string& bytes) {
  bytes += static_cast<char>(value & 0xFF);
  bytes += static_cast<char>(value >> 8);
}

inline void AppendWord32(std::uint32_t value, std::string& bytes) {
  AppendWord16(static_cast<std::uint16_t>(value & 0xFFFF), bytes);
  AppendWord16(static_cast<std::uint16_t>(value >> 16), bytes);
}

inline void AppendReal(float value, std::string& bytes) {
  AppendWord32(std::bit_cast<std::uint32_t>(value), bytes);
}

}  // namespace motiondb::core
