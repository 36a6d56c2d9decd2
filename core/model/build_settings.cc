#include "core/model/build_settings.h"

#include "core/motion/error.h"

namespace motiondb::core {
namespace {

constexpr int kLowestMinFrames = 2;  // one frame has no variance
constexpr int kHighestMinFrames = 1'000'000;

}  // namespace

absl::Status CheckSettings(const BuildSettings& settings) {
  const double rate = settings.frame_rate_hz;
  if (!(rate >= kMinFrameRate_hz && rate <= kMaxFrameRate_hz)) {
    return FieldViolation("frame_rate_hz", "expected {} to {}, got {}", kMinFrameRate_hz,
                          kMaxFrameRate_hz, rate);
  }
  if (settings.min_frames < kLowestMinFrames || settings.min_frames > kHighestMinFrames) {
    return FieldViolation("min_frames", "expected {} to {}, got {}", kLowestMinFrames,
                          kHighestMinFrames, settings.min_frames);
  }
  return absl::OkStatus();
}

}  // namespace motiondb::core
