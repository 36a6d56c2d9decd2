// The bytes of a C3D file as the processor that wrote them had numbers: Intel (PC), DEC (VAX) or
// MIPS (SGI). Offsets are from the start of the file. A view: the caller keeps the bytes.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "absl/status/status.h"
#include "core/format/motion_file.h"
#include "core/motion/error.h"

namespace motiondb::core {

inline constexpr std::size_t kC3dBlock = 512;  // bytes

enum class C3dProcessor { kIntel = 84, kDec = 85, kMips = 86 };

class C3dBytes {
 public:
  C3dBytes(SourceFile file, C3dProcessor processor) : file_(file), processor_(processor) {}

  std::size_t size() const { return file_.bytes.size(); }

  // OK if `count` bytes are there from `offset`; otherwise the error says what they were to be.
  absl::Status Require(std::size_t offset, std::size_t count, std::string_view what) const;

  // REQUIRES of those below: the bytes are there.
  std::uint8_t Byte(std::size_t offset) const;
  std::uint16_t Word(std::size_t offset) const;
  std::int16_t SignedWord(std::size_t offset) const;
  float Real(std::size_t offset) const;  // NaN or infinite if the bytes say so
  std::string_view Text(std::size_t offset, std::size_t count) const;

  // "walk.c3d: byte 512: ..."
  template <typename... Args>
  absl::Status Error(std::size_t offset, fmt::format_string<Args...> format, Args&&... args) const {
    return InvalidArgument("{}: byte {}: {}", file_.name, offset,
                           fmt::format(format, std::forward<Args>(args)...));
  }

 private:
  SourceFile file_;
  C3dProcessor processor_;
};

}  // namespace motiondb::core
