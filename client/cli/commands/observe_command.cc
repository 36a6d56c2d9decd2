// motiondb observe DB FILE: sends a motion frame by frame, like a robot, and shows the answers.
#include <fmt/format.h>
#include <motiondb/v1/observe.pb.h>

#include <optional>

#include "client/cli/command.h"
#include "client/cli/database_text.h"
#include "client/cli/observe_replay.h"
#include "client/cli/query/query_options.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {
namespace {

constexpr double kLineEvery = 0.1;  // seconds of motion; not on a terminal

struct ObserveCommandOptions {
  QueryOptions query;
  std::string track;
  bool realtime = false;
  double rate_multiplier = 1;
  int frames_per_message = 1;
  double window_seconds = 0.4;
  double unknown_threshold = kDefaultUnknownThreshold;
  std::vector<double> horizon_seconds;
};

void Declare(CLI::App& command, ObserveCommandOptions& options) {
  AddQueryOptionsOfOneFile(command, options.query);
  AddTrackOption(command, options.track);
  CLI::Option* realtime =
      command.add_flag("--realtime", options.realtime,
                       "Send at the frame rate of the motion; else as fast as possible");
  command
      .add_option("--rate-multiplier", options.rate_multiplier,
                  "Factor of the frame rate of the motion at which to send")
      ->type_name("X")
      ->check(PositiveNumber())
      ->needs(realtime)
      ->capture_default_str();
  command
      .add_option("--frames-per-message", options.frames_per_message,
                  "Number of frames in a message")
      ->type_name("N")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command.add_option("--window", options.window_seconds, "Window of labels and familiarity")
      ->type_name("SECONDS")
      ->check(PositiveNumber())
      ->capture_default_str();
  AddUnknownThresholdOption(command, options.unknown_threshold);
  command
      .add_option("--horizon", options.horizon_seconds,
                  "Horizons of the prediction; else no prediction")
      ->type_name("SECONDS,...")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(PositiveNumber());
  command.footer(
      "If the server stops, continues at another address of --server, or when it has started "
      "again, for at most 10 s. Standard error has what is lost.");
}

v1::ObserveStart Start(const ObserveCommandOptions& options, const v1::RepresentRequest& request,
                       const v1::MarkerObservation& motion) {
  v1::ObserveStart start;
  start.set_database(request.database());
  *start.mutable_marker_names() = motion.marker_names();
  start.set_frame_rate_hz(motion.frame_rate_hz());
  if (options.query.source.leg_length_m > 0) {
    start.set_leg_length_m(options.query.source.leg_length_m);
  }
  start.set_window_seconds(options.window_seconds);
  start.set_filter(options.query.filter);
  start.set_track(options.track);
  start.set_min_revision(options.query.min_revision);
  for (const double horizon : options.horizon_seconds) start.add_horizon_seconds(horizon);
  if (options.query.layer > 0) start.set_layer(options.query.layer);
  if (options.query.floor) start.set_transition_floor(*options.query.floor);
  return start;
}

// Shows answers when they arrive: on a terminal one line that changes, otherwise separate lines.
class LiveLine {
 public:
  LiveLine(double frame_rate_hz, double unknown_threshold)
      : frame_rate_hz_(frame_rate_hz),
        unknown_threshold_(unknown_threshold),
        terminal_(IsOnTerminal()) {}

  void Show(const v1::ObserveResponse& answer) {
    const double seconds = static_cast<double>(answer.frame()) / frame_rate_hz_;
    const std::string line = ObserveAnswerLine(answer, seconds, unknown_threshold_);
    if (terminal_) {
      ClearOutputLine();
      PrintText(Shortened(line, OutputSize().columns - 1));
      FlushOutput();
    } else if (!shown_ || seconds >= *shown_ + kLineEvery - 1e-9 || answer.model_replaced()) {
      PrintLineText(line);
      shown_ = seconds;
    }
  }
  void End() const {
    if (terminal_) PrintText("\n");
  }

 private:
  const double frame_rate_hz_;
  const double unknown_threshold_;
  const bool terminal_;
  std::optional<double> shown_;
};

absl::Status Run(const ObserveCommandOptions& options, const GlobalOptions& global) {
  v1::RepresentRequest request;
  auto observation = ObservationFromFile(options.query.files.front(), options.query.source);
  if (!observation.ok()) return observation.status();
  request.set_database(DatabaseName(options.query.database));
  *request.mutable_observation() = *std::move(observation);
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto represented = client->Represent(request);
  if (!represented.ok()) return represented.status();
  const v1::MarkerObservation& motion = represented->markers();

  ReplayOptions replay{.frames_per_message = options.frames_per_message};
  if (options.realtime) replay.frames_per_second = options.rate_multiplier * motion.frame_rate_hz();
  LiveLine line(motion.frame_rate_hz(), options.unknown_threshold);
  replay.on_reconnect = [&](const ObserveReconnect& reconnect) {
    if (!global.json) line.End();
    PrintError(ReconnectText(reconnect, motion.frame_rate_hz()));
  };
  v1::ObserveResponse last;
  const auto statistics = Replay(*client, Start(options, request, motion), motion, replay,
                                 [&](const v1::ObserveResponse& answer) {
                                   if (global.json) {
                                     PrintJson(answer);
                                   } else {
                                     line.Show(answer);
                                   }
                                   if (options.realtime) FlushOutput();
                                   last = answer;
                                 });
  if (!global.json) line.End();
  if (!statistics.ok()) return statistics.status();
  if (!global.json) {
    PrintText(ReplayText(*statistics, last, options.realtime) + UnknownNote(last.calibration()));
  }
  return absl::OkStatus();
}

}  // namespace

void AddObserveCommand(CommandLine line) {
  AddCommand<ObserveCommandOptions>(
      line, "observe", "Send a motion frame by frame and show the answers",
      "motiondb observe walks observed.bvh --realtime\nmotiondb observe "
      "walks observed.bvh --horizon 0.2,0.4 --json",
      Declare, Run);
}

}  // namespace motiondb::client
