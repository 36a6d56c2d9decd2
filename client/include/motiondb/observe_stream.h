// motiondb::client::ObserveStream: frames go out as they are captured, and what they mean comes
// back. Made by Client::Observe.
//
// Thread-safety: one thread may send while another receives; Cancel may be called from any thread.
// Ownership: a stream shares its client's connection, and may outlive the client. Destroying one
// that has not finished cancels it.
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

  // Sends `frame_count` frames numbered from `first_frame` on: frames x 3 markers, x y z of each
  // marker in turn, metres, in the world, z up; NaN in all three where a marker is missing. Waits
  // while the server has not taken earlier ones. False when the stream is over: Finish says why.
  bool Send(std::int64_t first_frame, int frame_count, std::span<const float> positions_m);

  // Says that no more frames will come. The answers to those sent still do.
  void EndOfFrames();

  // Waits for the answer to the next message of frames. False when the stream is over.
  bool Receive(v1::ObserveResponse& answer);

  // How the stream ended. Passes over answers that were not received; so, unless the server ends
  // the stream, call EndOfFrames before, and no other function meanwhile.
  absl::Status Finish();

  // Ends the stream at once, with what is under way.
  void Cancel();

 private:
  friend class Client;
  class Call;
  explicit ObserveStream(std::unique_ptr<Call> call);

  std::unique_ptr<Call> call_;
};

}  // namespace motiondb::client
