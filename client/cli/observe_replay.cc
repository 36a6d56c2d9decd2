#include "client/cli/observe_replay.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <mutex>
#include <thread>

namespace motiondb::client {
namespace {

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

// When each message was sent. The sender adds, the receiver reads.
class SendTimes {
 public:
  void Add() {
    const std::lock_guard lock(mutex_);
    times_.push_back(Clock::now());
  }
  Clock::time_point Of(std::size_t message) const {
    const std::lock_guard lock(mutex_);
    return times_.at(message);
  }

 private:
  mutable std::mutex mutex_;
  std::vector<Clock::time_point> times_;
};

void SendAll(const std::vector<float>& positions, int frame_count, const ReplayOptions& options,
             ObserveStream& stream, SendTimes& times) {
  const std::size_t width = positions.size() / static_cast<std::size_t>(frame_count);
  const auto begin = Clock::now();
  for (int first = 0; first < frame_count; first += options.frames_per_message) {
    const int count = std::min(options.frames_per_message, frame_count - first);
    if (options.frames_per_second > 0) {
      // A message leaves when its last frame would have been captured.
      std::this_thread::sleep_until(
          begin + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(
                      (first + count - 1) / options.frames_per_second)));
    }
    times.Add();
    const std::span frames(positions.data() + width * static_cast<std::size_t>(first),
                           width * static_cast<std::size_t>(count));
    if (!stream.Send(first, count, frames)) return;
  }
  stream.EndOfFrames();
}

}  // namespace

absl::StatusOr<ReplayFigures> Replay(
    const Client& client, const v1::ObserveStart& start, const v1::MarkerObservation& motion,
    const ReplayOptions& options,
    const std::function<void(const v1::ObserveResponse&)>& on_answer) {
  if (motion.frame_count() < 1) return absl::InvalidArgumentError("the motion has no frames");
  std::vector<float> positions(motion.positions().size() / sizeof(float));
  std::memcpy(positions.data(), motion.positions().data(), positions.size() * sizeof(float));

  ObserveStream stream = client.Observe(start);
  SendTimes times;
  ReplayFigures figures{.frames = motion.frame_count()};
  const auto begin = Clock::now();
  std::thread sender(SendAll, std::cref(positions), motion.frame_count(), std::cref(options),
                     std::ref(stream), std::ref(times));
  v1::ObserveResponse answer;
  while (stream.Receive(answer)) {
    figures.latencies_ms.push_back(MillisecondsSince(times.Of(figures.latencies_ms.size())));
    on_answer(answer);
  }
  figures.seconds = MillisecondsSince(begin) / 1000;
  sender.join();
  if (const absl::Status status = stream.Finish(); !status.ok()) return status;
  return figures;
}

}  // namespace motiondb::client
