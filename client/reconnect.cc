#include "client/reconnect.h"

#include <motiondb/call_error.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

namespace motiondb::client {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirstDelay{200};
constexpr milliseconds kMaxDelay{10'000};
constexpr int kMaxDoublings = 6;  // from kFirstDelay beyond kMaxDelay

// Between 80 % and 100 %, so that the clients of a restarted server do not return together.
milliseconds Jittered(milliseconds delay) {
  thread_local std::minstd_rand random{std::random_device{}()};
  return milliseconds(std::uniform_int_distribution<int>(static_cast<int>(delay.count()) * 4 / 5,
                                                         static_cast<int>(delay.count()))(random));
}

}  // namespace

ReconnectDelays::ReconnectDelays(int address_count) : other_addresses_(address_count - 1) {}

std::optional<milliseconds> ReconnectDelays::Next(const absl::Status& error) {
  const auto server_delay = RetryDelay(error);
  if (!absl::IsUnavailable(error) && !server_delay) return std::nullopt;
  const int doublings = std::min(attempts_++ - other_addresses_, kMaxDoublings);
  const milliseconds delay = doublings < 0
                                 ? milliseconds(0)
                                 : Jittered(std::min(kFirstDelay * (1 << doublings), kMaxDelay));
  return std::max(delay, server_delay.value_or(milliseconds(0)));
}

void ReconnectDelays::Reset() { attempts_ = 0; }

namespace {

// A server measures the leg length over the first second.
constexpr double kLegLengthSeconds = 1;
constexpr double kDefaultSeconds = 0.4;  // of window and history
constexpr double kMaxKeptFrames = 1e6;   // the server refuses wrong values; they must fit here

std::int64_t KeptFrames(const v1::ObserveStart& start) {
  const double window = start.has_window_seconds() ? start.window_seconds() : kDefaultSeconds;
  const double history = start.has_history_seconds() ? start.history_seconds() : kDefaultSeconds;
  const double frames =
      std::ceil(std::max({window, history, kLegLengthSeconds}) * start.frame_rate_hz());
  return static_cast<std::int64_t>(frames >= 1 ? std::min(frames, kMaxKeptFrames) : 1);
}

// Less than a window of HTTP/2 (64 KiB).
constexpr std::size_t kAheadBytes = std::size_t{32} << 10;

std::size_t Size(const v1::ObserveRequest& message) { return message.ByteSizeLong(); }

std::int64_t End(const v1::ObserveRequest& message) {
  return message.frames().first_frame() + message.frames().frame_count();
}

}  // namespace

SentFrames::SentFrames(const v1::ObserveStart& start) : kept_frames_(KeptFrames(start)) {}

void SentFrames::Add(v1::ObserveRequest message) {
  unanswered_bytes_ += Size(message);
  messages_.push_back(std::move(message));
}

const v1::ObserveRequest& SentFrames::NextToWrite() {
  const v1::ObserveRequest& message = messages_[written_++];
  in_flight_bytes_ += Size(message);
  return message;
}

bool SentFrames::CanWriteAhead() const {
  if (is_written()) return false;
  return written_ == received_ || in_flight_bytes_ + Size(messages_[written_]) <= kAheadBytes;
}

bool SentFrames::Answered() {
  if (received_ == written_) return true;  // a wrong server: an answer without a message
  const v1::ObserveRequest& message = messages_[received_++];
  in_flight_bytes_ -= Size(message);
  if (received_ <= answered_) return false;
  answered_ = received_;
  unanswered_bytes_ -= Size(message);
  const std::int64_t newest = End(message);
  while (answered_ > 1 && End(messages_.front()) <= newest - kept_frames_) {
    forgotten_frames_ += messages_.front().frames().frame_count();
    messages_.pop_front();
    --answered_;
    --written_;
    --received_;
  }
  return true;
}

void SentFrames::WriteAgain() { written_ = received_ = in_flight_bytes_ = 0; }

std::int64_t SentFrames::unanswered_frames() const {
  std::int64_t frames = 0;
  for (std::size_t i = answered_; i < messages_.size(); ++i) {
    frames += messages_[i].frames().frame_count();
  }
  return frames;
}

std::int64_t SentFrames::first_unanswered() const {
  return is_answered() ? 0 : messages_[answered_].frames().first_frame();
}

std::int64_t SentFrames::first_frame() const {
  return messages_.empty() ? 0 : messages_.front().frames().first_frame();
}

}  // namespace motiondb::client
