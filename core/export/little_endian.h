// Appends numbers to the bytes of a file, least significant byte first.
#pragma once

#include <bit>
#include <cstdint>
#include <string>

namespace motiondb::core {

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
