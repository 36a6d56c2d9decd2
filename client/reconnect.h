// Streams that continue at another server after an error: when they are opened again, and what is
// sent again.
#pragma once

#include <motiondb/v1/observe.pb.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "absl/status/status.h"

namespace motiondb::client {

// Delays between attempts to open a stream again. Not thread-safe.
class ReconnectDelays {
 public:
  // `address_count`: addresses of the client. The first attempts are made without a delay, so that
  // each other server is tried; if there is none, after 0.2 s. Later delays double, up to 10 s.
  explicit ReconnectDelays(int address_count);

  // Returns the delay of the next attempt, at least the retry delay in `error`. nullopt if `error`
  // is not UNAVAILABLE and has no retry delay: another attempt would not fix it.
  std::optional<std::chrono::milliseconds> Next(const absl::Status& error);

  // The stream works: the next attempt is a first one.
  void Reset();

 private:
  const int other_addresses_;
  int attempts_ = 0;
};

// The messages of an Observe stream that a new server needs if the present one dies. A queue, in
// the order of their frames: answered ones, as far as a new server needs them, then those without
// an answer, of which the last ones may not be written yet. Not thread-safe.
class SentFrames {
 public:
  // Keeps the answered frames of the longest time over which `start` makes a server look back.
  explicit SentFrames(const v1::ObserveStart& start);

  void Add(v1::ObserveRequest message);

  // Returns the next message to write to the present server. Valid until it has been answered.
  const v1::ObserveRequest& NextToWrite();
  bool is_written() const { return written_ == messages_.size(); }
  // Whether the thread that receives may write the next message, without blocking: a server with
  // an answer that is not read yet does not read.
  bool CanWriteAhead() const;

  // The present server has answered the next written message. Returns false if the message already
  // had an answer, from an earlier server. Forgets old messages.
  bool Answered();

  // All messages must be written again, to a new server.
  void WriteAgain();

  bool is_answered() const { return answered_ == messages_.size(); }
  // The messages without an answer.
  std::size_t unanswered_bytes() const { return unanswered_bytes_; }
  std::int64_t unanswered_frames() const;
  std::int64_t first_unanswered() const;

  // Frames that are not in the queue any more, and the first one that is; 0 if it is empty.
  std::int64_t forgotten_frames() const { return forgotten_frames_; }
  std::int64_t first_frame() const;

 private:
  const std::int64_t kept_frames_;
  std::deque<v1::ObserveRequest> messages_;
  std::size_t answered_ = 0;  // messages at the front with an answer
  std::size_t written_ = 0;   // messages at the front written to the present server
  std::size_t received_ = 0;  // answers of the present server
  std::size_t unanswered_bytes_ = 0;
  std::size_t in_flight_bytes_ = 0;  // written and not answered by the present server
  std::int64_t forgotten_frames_ = 0;
};

}  // namespace motiondb::client
