// What a file's name says, and whether the same file was ingested before. Safe to call from any
// thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace motiondb::server {

// Without folders, of either kind of slash.
std::string WithoutFolders(std::string_view path);

// The clip id that a file's name (without folders) suggests: its stem, with '_' for each character
// that an id cannot have, and short enough for a number to be added; "clip" where nothing is left.
std::string ClipIdFromFileName(std::string_view file_name);

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
