// Memory of texts that grow by a line for each frame.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>

namespace motiondb::core {

// Reserves memory for `frames_left` further frames, each somewhat longer than `frame_bytes`. A text
// that doubles its memory instead needs up to three times its size.
inline void ReserveFrames(std::string& text, std::size_t frame_bytes, Eigen::Index frames_left) {
  const std::size_t with_margin = frame_bytes + frame_bytes / 10;
  text.reserve(text.size() + with_margin * static_cast<std::size_t>(frames_left));
}

}  // namespace motiondb::core
