// Sends a motion like a robot, a few frames per message at a given rate, and receives the answers.
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
  double frames_per_second = 0;  // 0: as fast as possible
  std::function<void(const ObserveReconnect&)> on_reconnect;
};

// Statistics of a replay.
struct ReplayStatistics {
  int frames = 0;
  double seconds = 0;  // from the first message to the last answer
  // Time from each message to its answer, in order.
  std::vector<double> latencies_ms;
};

// Calls `on_answer` with each answer, on the calling thread. Returns the error of the stream.
absl::StatusOr<ReplayStatistics> Replay(
    const Client& client, const v1::ObserveStart& start, const v1::MarkerObservation& motion,
    const ReplayOptions& options, const std::function<void(const v1::ObserveResponse&)>& on_answer);

// Returns a line without line end. `seconds`: time of the newest frame in the motion. The line
// begins with "unknown" if the probability of unknown motion is greater than `unknown_threshold`,
// and has the labels of other tracks, as in "carries: box 0.80".
std::string ObserveAnswerLine(const v1::ObserveResponse& answer, double seconds,
                              double unknown_threshold);

// Returns what a stream has lost with its server, without line end.
std::string ReconnectText(const ObserveReconnect& reconnect, double frame_rate_hz);

// Returns a summary. `paced`: messages were sent at a fixed rate, so that latencies are meaningful.
std::string ReplayText(const ReplayStatistics& statistics, const v1::ObserveResponse& last,
                       bool paced);

}  // namespace motiondb::client
