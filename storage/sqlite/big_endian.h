// Big-endian numbers, as in SQLite's files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace motiondb::storage {

// Returns the four bytes at offset `place` as a number. REQUIRES: place + 4 <= bytes.size().
inline std::uint32_t BigEndian(std::string_view bytes, std::size_t place) {
  std::uint32_t value = 0;
  for (std::size_t i = place; i < place + 4; ++i) {
    value = value << 8 | static_cast<unsigned char>(bytes[i]);
  }
  return value;
}

}  // namespace motiondb::storage
