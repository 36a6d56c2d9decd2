// Sends a motion as a robot would, a few frames a message at a set pace, and takes the answers.
#pragma once

#include <motiondb/client.h>
#include <motiondb/v1/observe.pb.h>

#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace motiondb::client {

struct ReplayOptions {
  int frames_per_message = 1;
  double frames_per_second = 0;  // 0: as fast as the server answers
};

// What a replay came to.
struct ReplayFigures {
  int frames = 0;
  double seconds = 0;  // from the first message to the last answer
  // From sending each message to its answer, in their order.
  std::vector<double> latencies_ms;
};

// `on_answer` is called with each answer, on the calling thread. The status is the stream's.
absl::StatusOr<ReplayFigures> Replay(
    const Client& client, const v1::ObserveStart& start, const v1::MarkerObservation& motion,
    const ReplayOptions& options, const std::function<void(const v1::ObserveResponse&)>& on_answer);

// What a stream of frames says, for people. Pure functions.

// One line, without its end. `seconds`: where in the motion its newest frame is.
std::string ObservedLine(const v1::ObserveResponse& answer, double seconds);

// `paced`: messages were sent at a rate of their own, so that how long answers took says something.
std::string ReplayText(const ReplayFigures& figures, const v1::ObserveResponse& last, bool paced);

}  // namespace motiondb::client
