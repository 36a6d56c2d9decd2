// Numbers as SQLite's files have them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace motiondb::storage {

// The four bytes at `place` as a number. REQUIRES: `bytes` has them.
inline std::uint32_t BigEndian(std::string_view bytes, std::size_t place) {
  std::uint32_t value = 0;
  for (std::size_t i = place; i < place + 4; ++i) {
    value = value << 8 | static_cast<unsigned char>(bytes[i]);
  }
  return value;
}

}  // namespace motiondb::storage
