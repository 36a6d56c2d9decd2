// motiondb::client::ObserveStream: sends frames as they are captured and receives an answer to each
// message. Client::Observe opens it.
//
// Thread-safety: one thread may send while another receives; Cancel may be called from any thread.
// Ownership: a stream shares the connection of its client and may outlive the client. The
// destructor cancels a stream that has not ended.
#pragma once

#include <motiondb/messages.h>

#include <cstdint>
#include <memory>
#include <span>

#include "absl/status/status.h"

namespace motiondb::client {

class ObserveStream {
 public:
  ObserveStream(ObserveStream&&) noexcept;
  ObserveStream& operator=(ObserveStream&&) noexcept;
  ~ObserveStream();

  // Sends frames `first_frame` to `first_frame + frame_count - 1`. `positions_m`: frame_count x
  // 3 markers, x y z of each marker, world frame, z up; NaN for a missing marker. Blocks while the
  // flow control of the stream does. Returns false if the stream has ended; Finish returns why.
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
