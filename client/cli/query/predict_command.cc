// motiondb predict DB FILE...: the motion after one or many times.
#include <motiondb/v1/observe.pb.h>
#include <motiondb/v1/query.pb.h>

#include <optional>
#include <vector>

#include "client/cli/command.h"
#include "client/cli/query/estimation_prediction_text.h"
#include "client/cli/query/query_files.h"
#include "client/cli/query/query_options.h"

namespace motiondb::client {

namespace {

struct PredictOptions {
  static constexpr bool kPrintsTable = true;
  QueryOptions query;
  v1::Method method = v1::METHOD_BEST;
  std::optional<double> at_seconds;
  std::optional<double> every_seconds;
  double history_seconds = 0.4;
  std::vector<double> horizon_seconds = {0.08, 0.16, 0.32, 0.4, 0.56, 1.0};
  bool compare = false;
  double unknown_threshold = kDefaultUnknownThreshold;
};

void Declare(CLI::App& command, PredictOptions& options) {
  AddQueryOptions(command, options.query);
  CLI::Option* at = command.add_option("--at", options.at_seconds,
                                       "Time to predict from; else the end of the motion");
  at->type_name("SECONDS")->check(NonNegativeNumber());
  command
      .add_option("--every", options.every_seconds,
                  "Interval of repeated predictions, from the first time with a full history")
      ->type_name("SECONDS")
      ->check(PositiveNumber())
      ->excludes(at);
  command
      .add_option("--history", options.history_seconds,
                  "Length of the motion before that time that is used")
      ->type_name("SECONDS")
      ->check(PositiveNumber())
      ->capture_default_str();
  command
      .add_option("--horizon", options.horizon_seconds, "Horizons of predicted marker positions")
      ->type_name("SECONDS,...")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(PositiveNumber())
      ->capture_default_str();
  command.add_flag("--compare", options.compare,
                   "Print the error against the motion that follows in the file; does not change "
                   "the output of --json");
  AddMethodOption(command, options.method);
  AddUnknownThresholdOption(command, options.unknown_threshold);
}

v1::PredictRequest Request(const PredictOptions& options) {
  v1::PredictRequest request;
  if (options.at_seconds) request.set_at_seconds(*options.at_seconds);
  request.set_history_seconds(options.history_seconds);
  for (const double horizon : options.horizon_seconds) request.add_horizon_seconds(horizon);
  request.set_method(options.method);
  return request;
}

absl::Status Run(const PredictOptions& options, const GlobalOptions& global) {
  v1::PredictRequest request = Request(options);
  SetQuery(options.query, request);
  return AskForFiles(
      options.query, global, [&](const Client& client, QueriedFile& file) -> absl::Status {
        *request.mutable_observation() = file.TakeObservation();
        PredictionView view{.unknown_threshold = options.unknown_threshold};
        if (options.compare && !global.json) {
          v1::RepresentRequest whole;
          whole.set_database(request.database());
          *whole.mutable_observation() = request.observation();
          const auto represented = client.Represent(whole);
          if (!represented.ok()) return represented.status();
          view.motion_m = UnpackFloats(represented->markers().positions());
          view.frame_rate_hz = represented->markers().frame_rate_hz();
        }
        const auto print = [&](const v1::PredictResponse& response) {
          file.Print(
              response, [&] { return PredictionText(response, view); },
              [&] { return PredictionTable(response, view); });
          return absl::OkStatus();
        };
        if (options.every_seconds) {
          v1::PredictSeriesRequest series;
          *series.mutable_prediction() = request;
          series.set_every_seconds(*options.every_seconds);
          return client.PredictSeries(series, [&](const v1::PredictSeriesResponse& response) {
            return print(response.prediction());
          });
        }
        const auto response = client.Predict(request);
        return response.ok() ? print(*response) : response.status();
      });
}

}  // namespace

void AddPredictCommand(CommandLine line) {
  AddCommand<PredictOptions>(line, "predict", "Predict the motion from one or many times of a file",
                             "motiondb predict walks observed.bvh\n"
                             "motiondb predict walks observed.bvh --at 3 --horizon 0.1,0.5\n"
                             "motiondb predict walks observed.bvh --at 3 --compare\n"
                             "motiondb predict walks observed.bvh --every 0.5 --csv",
                             Declare, Run);
}

}  // namespace motiondb::client
