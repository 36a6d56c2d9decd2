// motiondb::client::ObserveStream: sends frames as they are captured and receives an answer to each
// message, also across the death of the server. Client::Observe opens it.
//
// If the server dies or stops, Receive opens the stream again, at the next address of the client,
// and sends the last frames again: those without an answer, and before them those of the last
// second, or of the window or history if they are longer. So each message gets one answer, in
// order. Only the frames before them are lost: the new server does not know them, and its answers
// do not depend on them (ObserveReconnect). `late_frames` and `missing_frames` of the answers
// continue to count.
//
// Thread-safety: one thread may send while another receives; Cancel may be called from any thread.
// Ownership: a stream shares the connection of its client and may outlive the client. The
// destructor cancels a stream that has not ended.
#pragma once

#include <motiondb/messages.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "absl/status/status.h"

namespace motiondb::client {

// What a stream has lost with its server.
struct ObserveReconnect {
  absl::Status error;                     // why the stream ended at the earlier server
  std::chrono::milliseconds duration{0};  // from that end to the first answer of the new server
  std::int64_t lost_frames = 0;           // sent frames that the new server does not know
  std::int64_t first_frame = 0;           // number of the first frame that it knows
};

struct ObserveOptions {
  // Time limit of the whole stream. Absent: unlimited.
  std::optional<std::chrono::milliseconds> timeout;
  // Time to find a server again. After it, or immediately if it is 0, the stream ends with the
  // error; the message has the frames without an answer.
  std::chrono::milliseconds reconnect_timeout{10'000};
  // Called by Receive before it returns the first answer of a new server. May be null.
  std::function<void(const ObserveReconnect&)> on_reconnect;
};

class ObserveStream {
 public:
  ObserveStream(ObserveStream&&) noexcept;
  ObserveStream& operator=(ObserveStream&&) noexcept;
  ~ObserveStream();

  // Sends frames `first_frame` to `first_frame + frame_count - 1`. `positions_m`: frame_count x
  // 3 markers, x y z of each marker, world frame, z up; NaN for a missing marker. Blocks while the
  // flow control of the stream does, and without a server from 8 MiB without an answer on. Returns
  // false if the stream has ended, which Receive finds out; Finish returns why.
  bool Send(std::int64_t first_frame, int frame_count, std::span<const float> positions_m);

  // Announces that no more frames follow. Answers to the sent frames can still be received.
  void EndOfFrames();

  // Waits for the answer to the next message of frames. Returns false if the stream has ended.
  bool Receive(v1::ObserveResponse& answer);

  // Waits for the end of the stream and returns its status. Discards remaining answers. Call
  // EndOfFrames first, unless the server has ended the stream; call no other function meanwhile.
  absl::Status Finish();

  // Cancels the stream immediately, with calls in progress.
  void Cancel();

 private:
  friend class Client;
  class Call;
  explicit ObserveStream(std::unique_ptr<Call> call);

  std::unique_ptr<Call> call_;
};

}  // namespace motiondb::client
