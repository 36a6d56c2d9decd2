// Tells whether the same files were ingested before.
#pragma once

#include <cstdint>
#include <string_view>

namespace motiondb::server {

// 64-bit FNV-1a of the motion file's length, its bytes and the skeleton file's bytes.
inline std::uint64_t ContentHash(std::string_view file, std::string_view skeleton) {
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&](std::uint8_t byte) { hash = (hash ^ byte) * 0x100000001b3; };
  for (int shift = 0; shift < 64; shift += 8) {
    add(static_cast<std::uint8_t>(std::uint64_t{file.size()} >> shift));
  }
  for (const char c : file) add(static_cast<std::uint8_t>(c));
  for (const char c : skeleton) add(static_cast<std::uint8_t>(c));
  return hash;
}

}  // namespace motiondb::server
