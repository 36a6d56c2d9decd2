#include "core/model/frame_stride.h"

#include <algorithm>
#include <cmath>

#include "core/model/model.h"

namespace motiondb::core {

int FrameStride(double frame_rate_hz) {
  return std::max(1, static_cast<int>(std::lround(frame_rate_hz / 30)));
}

StridedFrames StrideFrames(const std::vector<ModelClip>& clips, double frame_rate_hz) {
  const int stride = FrameStride(frame_rate_hz);
  StridedFrames strided;
  for (const ModelClip& clip : clips) {
    strided.begin.push_back(static_cast<int>(strided.frame.size()));
    for (int f = 0; f < clip.frame_count; f += stride) {
      strided.frame.push_back(clip.first_frame + f);
    }
  }
  strided.begin.push_back(static_cast<int>(strided.frame.size()));
  return strided;
}

}  // namespace motiondb::core
