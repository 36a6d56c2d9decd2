#include "client/cli/observe_replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "client/cli/database_text.h"
#include "client/cli/query/recognition_text.h"
#include "client/cli/terminal/print.h"
#include "text/display_text.h"

namespace motiondb::client {

namespace {

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

// The time when each message was sent. The sender adds, the receiver reads. Thread-safe.
class SendTimes {
 public:
  void Add() {
    const absl::MutexLock lock(&mutex_);
    times_.push_back(Clock::now());
  }
  Clock::time_point Of(std::size_t message) const {
    const absl::MutexLock lock(&mutex_);
    return times_.at(message);
  }

 private:
  mutable absl::Mutex mutex_;
  std::vector<Clock::time_point> times_ ABSL_GUARDED_BY(mutex_);
};

void SendAll(const std::vector<float>& positions, int frame_count, const ReplayOptions& options,
             ObserveStream& stream, SendTimes& times) {
  const std::size_t width = positions.size() / static_cast<std::size_t>(frame_count);
  const auto begin = Clock::now();
  for (int first = 0; first < frame_count; first += options.frames_per_message) {
    const int count = std::min(options.frames_per_message, frame_count - first);
    if (options.frames_per_second > 0) {
      // Sends a message at the capture time of its last frame.
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

absl::StatusOr<ReplayStatistics> Replay(
    const Client& client, const v1::ObserveStart& start, const v1::MarkerObservation& motion,
    const ReplayOptions& options,
    const std::function<void(const v1::ObserveResponse&)>& on_answer) {
  if (motion.frame_count() < 1) return absl::InvalidArgumentError("the motion has no frames");
  std::vector<float> positions(motion.positions().size() / sizeof(float));
  std::memcpy(positions.data(), motion.positions().data(), positions.size() * sizeof(float));

  ObserveStream stream = client.Observe(start, {.on_reconnect = options.on_reconnect});
  SendTimes times;
  ReplayStatistics statistics{.frames = motion.frame_count()};
  const auto begin = Clock::now();
  std::thread sender(SendAll, std::cref(positions), motion.frame_count(), std::cref(options),
                     std::ref(stream), std::ref(times));
  v1::ObserveResponse answer;
  while (stream.Receive(answer)) {
    statistics.latencies_ms.push_back(MillisecondsSince(times.Of(statistics.latencies_ms.size())));
    on_answer(answer);
  }
  statistics.seconds = MillisecondsSince(begin) / 1000;
  sender.join();
  if (const absl::Status status = stream.Finish(); !status.ok()) return status;
  return statistics;
}

namespace {

constexpr int kLabelsOfMoment = 2;
constexpr int kLabelsWidth = 26;
constexpr int kLabelsWidthWithUnknown = 34;  // without horizons, a line then fits 80 columns

// Returns the `fraction` quantile; `sorted` is not empty.
double Quantile(const std::vector<double>& sorted, double fraction) {
  const auto rank =
      static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(sorted.size())));
  return sorted[std::max<std::size_t>(rank, 1) - 1];
}

// Returns "walk 0.90, jog 0.08, unknown 0.02"; begins with "unknown" if the window is called so.
std::string LabelsText(const v1::ObserveResponse& answer, double unknown_threshold) {
  std::vector<std::string> cells;
  for (int i = 0; i < std::min(answer.labels_size(), kLabelsOfMoment); ++i) {
    cells.push_back(fmt::format("{} {:.2f}", LabelOrPlaceholder(answer.labels(i).label()),
                                answer.labels(i).probability()));
  }
  if (answer.has_unknown_probability()) {
    cells.insert(IsUnknown(answer, unknown_threshold) ? cells.begin() : cells.end(),
                 UnknownText(answer.unknown_probability()));
  }
  return fmt::format("{}", fmt::join(cells, ", "));
}

}  // namespace

std::string ObserveAnswerLine(const v1::ObserveResponse& answer, double seconds,
                              double unknown_threshold) {
  std::string line = fmt::format("{:7.2f} s  ", seconds);
  if (!answer.has_state()) {
    line += "no frame with both hips yet";
  } else {
    line += fmt::format(
        "{:<{}} familiarity {:.2f}  node {:>4} {:.2f}", LabelsText(answer, unknown_threshold),
        answer.has_unknown_probability() ? kLabelsWidthWithUnknown : kLabelsWidth,
        answer.familiarity(), answer.state().node_id(), answer.state().probability());
    if (answer.horizons_size() > 0) {
      const v1::PredictedFrame& ahead = answer.horizons(answer.horizons_size() - 1);
      line += fmt::format("  {:.2f} s ahead", ahead.seconds());
      if (ahead.has_expected_error_m()) {
        line += fmt::format(" +-{:.1f} cm", 100 * ahead.expected_error_m());
      }
    }
  }
  for (const v1::TrackLabels& track : answer.other_tracks()) {
    const TrackAnswer of_track = TrackAnswerOf(track);
    line += fmt::format("  {}: {} {:.2f}", text::DisplayText(track.track()), of_track.label,
                        of_track.probability);
  }
  if (answer.model_replaced()) {
    // A model that is not stored yet has no version.
    const bool is_stored = answer.calibration() != v1::CALIBRATION_PREVIOUS &&
                           answer.calibration() != v1::CALIBRATION_TYPICAL;
    line += is_stored ? fmt::format("  (now model {})", answer.model_version())
                      : "  (now a newer model, not calibrated yet)";
  }
  return line;
}

std::string ReconnectText(const ObserveReconnect& reconnect, double frame_rate_hz) {
  std::string text =
      fmt::format("{}; continued after {:.2f} s", std::string(reconnect.error.message()),
                  std::chrono::duration<double>(reconnect.duration).count());
  if (reconnect.lost_frames == 0) return text + "; no frame is lost";
  return text + fmt::format("; further answers do not depend on the {} before {:.2f} s",
                            CountText(reconnect.lost_frames, "frame"),
                            static_cast<double>(reconnect.first_frame) / frame_rate_hz);
}

std::string ReplayText(const ReplayStatistics& statistics, const v1::ObserveResponse& last,
                       bool paced) {
  std::vector<double> sorted = statistics.latencies_ms;
  std::sort(sorted.begin(), sorted.end());
  std::string text =
      fmt::format("{} in {:.2f} s, {:.0f} per second; model {}\n",
                  CountText(statistics.frames, "frame"), statistics.seconds,
                  statistics.frames / std::max(statistics.seconds, 1e-9), last.model_version());
  if (paced && !sorted.empty()) {
    text += fmt::format("{} after {:.2f} ms (median), {:.2f} (99 %), {:.2f} (longest)\n",
                        CountText(sorted.size(), "answer"), Quantile(sorted, 0.5),
                        Quantile(sorted, 0.99), sorted.back());
  }
  if (last.late_frames() + last.missing_frames() > 0) {
    text += fmt::format("{} late, {} missing\n", CountText(last.late_frames(), "frame"),
                        last.missing_frames());
  }
  return text;
}

}  // namespace motiondb::client
