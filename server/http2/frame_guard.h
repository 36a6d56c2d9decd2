// Filters a client's HTTP/2 frames before libnghttp2 reads them. It counts frames without a call,
// and hides a frame of gRPC's own clients for which libnghttp2 would close the connection.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

namespace motiondb::server {

class FrameGuard {
 public:
  using Clock = std::chrono::steady_clock;

  explicit FrameGuard(Clock::time_point began) : began_(began) {}

  // Copies the bytes that the last Pass kept to the beginning of `buffer` and returns their number,
  // at most 8. The next input follows them.
  std::size_t Resume(std::span<std::uint8_t> buffer) const;

  // `bytes` begin with those from Resume. Returns how many of them to pass to libnghttp2; the rest
  // is an incomplete frame header and is kept. Changes RST_STREAM of a stream that was never opened
  // into a frame type that libnghttp2 ignores: clients with gRPC's C core send it if a call is
  // cancelled as it begins (github.com/grpc/grpc/issues/19655). The connection must not end by it.
  std::size_t Pass(std::span<std::uint8_t> bytes);

  // True if the client sent more frames without a call than any proper client does.
  bool TooMany(Clock::time_point now) const;

 private:
  static constexpr std::size_t kHeaderBytes = 9;
  static constexpr std::size_t kPrefaceBytes = 24;

  void InspectHeader(std::span<std::uint8_t> header);

  const Clock::time_point began_;
  std::size_t payload_left_ = kPrefaceBytes;  // bytes before the next frame header
  std::array<std::uint8_t, kHeaderBytes - 1> kept_{};
  std::size_t kept_bytes_ = 0;
  std::uint32_t last_stream_ = 0;  // last stream that the client opened
  std::int64_t idle_frames_ = 0;   // frames without a call
  std::int64_t call_frames_ = 0;
};

}  // namespace motiondb::server
