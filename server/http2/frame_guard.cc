#include "server/http2/frame_guard.h"

#include <nghttp2/nghttp2.h>

#include <algorithm>

namespace motiondb::server {
namespace {

// Maximum of frames without a call, such as PING: the sum of these three.
constexpr std::int64_t kBaseIdleFrames = 10'000;
constexpr std::int64_t kIdleFramesPerSecond = 100;
constexpr std::int64_t kIdleFramesPerCallFrame = 8;

constexpr std::uint8_t kIgnoredType = 0xf0;  // RFC 9113 reserves it for experiments
constexpr std::size_t kResetPayload = 4;

}  // namespace

std::size_t FrameGuard::Resume(std::span<std::uint8_t> buffer) const {
  std::copy_n(kept_.begin(), kept_bytes_, buffer.begin());
  return kept_bytes_;
}

std::size_t FrameGuard::Pass(std::span<std::uint8_t> bytes) {
  std::size_t at = 0;
  while (true) {
    const std::size_t skipped = std::min(payload_left_, bytes.size() - at);
    payload_left_ -= skipped;
    at += skipped;
    if (bytes.size() - at < kHeaderBytes) break;
    InspectHeader(bytes.subspan(at, kHeaderBytes));
    at += kHeaderBytes;
  }
  kept_bytes_ = bytes.size() - at;
  std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), kept_bytes_, kept_.begin());
  return at;
}

void FrameGuard::InspectHeader(std::span<std::uint8_t> header) {
  const auto number = [&](std::size_t from, std::size_t to) {
    std::uint32_t value = 0;
    for (std::size_t i = from; i < to; ++i) value = value << 8 | header[i];
    return value;
  };
  payload_left_ = number(0, 3);
  std::uint8_t& type = header[3];
  const bool ends_stream = (header[4] & NGHTTP2_FLAG_END_STREAM) != 0;
  const std::uint32_t stream = number(5, 9) & 0x7fff'ffff;
  const bool is_call_frame =
      type == NGHTTP2_HEADERS || (type == NGHTTP2_DATA && (payload_left_ > 0 || ends_stream));
  ++(is_call_frame ? call_frames_ : idle_frames_);
  if (type == NGHTTP2_HEADERS) last_stream_ = std::max(last_stream_, stream);
  const bool is_client_stream = stream % 2 == 1;
  if (type == NGHTTP2_RST_STREAM && payload_left_ == kResetPayload && is_client_stream &&
      stream > last_stream_) {
    type = kIgnoredType;
  }
}

bool FrameGuard::TooMany(Clock::time_point now) const {
  const auto age = std::chrono::duration_cast<std::chrono::seconds>(now - began_).count();
  return idle_frames_ >
         kBaseIdleFrames + kIdleFramesPerCallFrame * call_frames_ + kIdleFramesPerSecond * age;
}

}  // namespace motiondb::server
