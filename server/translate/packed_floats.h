// Frames as they travel: float32, little-endian, row-major, without a header. Safe to call from any
// thread.
#pragma once

#include <bit>
#include <cstddef>
#include <cstring>
#include <string>

#include "core/motion/matrix.h"

namespace motiondb::server {

static_assert(std::endian::native == std::endian::little, "packed floats are copied as they are");

// Appends `count` floats.
inline void AppendPacked(const float* values, std::size_t count, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(float));
}

// rows x columns floats. REQUIRES: bytes.size() == rows * columns * 4.
inline core::FrameMatrix Unpack(const std::string& bytes, int rows, int columns) {
  core::FrameMatrix matrix(rows, columns);
  std::memcpy(matrix.data(), bytes.data(), bytes.size());
  return matrix;
}

}  // namespace motiondb::server
