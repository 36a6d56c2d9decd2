// A client's frames before libnghttp2 reads them: counts those that carry nothing of a call, and
// lets pass what libnghttp2 would close the connection for although gRPC's own clients send it.
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

  // Puts the bytes that the last Pass kept at the beginning of `buffer`, and returns how many they
  // are, at most 8: what the client sends next follows them.
  std::size_t Resume(std::span<std::uint8_t> buffer) const;

  // Returns how many of `bytes`, which begin with what Resume gave, libnghttp2 may have now. The
  // rest is a part of a frame's header, and is kept. Changes a RST_STREAM of a stream that was
  // never opened into a frame of a type that libnghttp2 ignores: clients with gRPC's C core send
  // one when a call is cancelled just as it begins (github.com/grpc/grpc/issues/19655), and must
  // not lose the other calls of their connection by it.
  std::size_t Pass(std::span<std::uint8_t> bytes);

  // Whether there were more frames without a call than any client has reason to send.
  bool TooMany(Clock::time_point now) const;

 private:
  static constexpr std::size_t kHeaderBytes = 9;
  static constexpr std::size_t kPrefaceBytes = 24;

  void Look(std::span<std::uint8_t> header);

  const Clock::time_point began_;
  std::size_t payload_left_ = kPrefaceBytes;  // before the next frame's header
  std::array<std::uint8_t, kHeaderBytes - 1> kept_{};
  std::size_t kept_bytes_ = 0;
  std::uint32_t last_stream_ = 0;  // that the client opened
  std::int64_t idle_frames_ = 0;   // that carry nothing of a call
  std::int64_t call_frames_ = 0;
};

}  // namespace motiondb::server
