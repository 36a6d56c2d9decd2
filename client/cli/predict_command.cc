// motiondb predict DB FILE: what comes next, at one moment or at many?
#include <motiondb/v1/query.pb.h>

#include <optional>

#include "client/cli/command.h"
#include "client/cli/json_output.h"
#include "client/cli/marker_names.h"
#include "client/cli/prediction_text.h"
#include "client/cli/print.h"
#include "client/cli/query_options.h"

namespace motiondb::client {
namespace {

struct PredictOptions {
  QueryOptions query;
  v1::Method method = v1::BEST;
  std::optional<double> at_seconds;
  std::optional<double> every_seconds;
  double history_seconds = 0.4;
  std::vector<double> horizon_seconds = {0.08, 0.16, 0.32, 0.4, 0.56, 1.0};
};

void Declare(CLI::App& command, PredictOptions& options) {
  AddQueryOptions(command, options.query);
  CLI::Option* at = command.add_option("--at", options.at_seconds,
                                       "The moment to predict from; else the end of the motion");
  at->type_name("SECONDS")->check(NonNegativeNumber());
  command
      .add_option("--every", options.every_seconds,
                  "Predict again and again, so far apart, from the first moment with a history")
      ->type_name("SECONDS")
      ->check(PositiveNumber())
      ->excludes(at);
  command.add_option("--history", options.history_seconds, "How much before the moment is used")
      ->type_name("SECONDS")
      ->check(PositiveNumber())
      ->capture_default_str();
  command
      .add_option("--horizon", options.horizon_seconds, "How far ahead to give marker positions")
      ->type_name("SECONDS,...")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(PositiveNumber())
      ->capture_default_str();
  AddMethodOption(command, options.method);
}

v1::PredictRequest Request(const PredictOptions& options) {
  v1::PredictRequest request;
  if (options.at_seconds) request.set_at_seconds(*options.at_seconds);
  request.set_history_seconds(options.history_seconds);
  for (const double horizon : options.horizon_seconds) request.add_horizon_seconds(horizon);
  request.set_method(options.method);
  return request;
}

// Prints predictions as they come.
class Printer {
 public:
  Printer(bool json, std::vector<std::string> marker_names)
      : json_(json), marker_names_(std::move(marker_names)) {}

  void Print(const v1::PredictResponse& prediction) {
    if (json_) {
      PrintJson(prediction);
    } else {
      PrintText((first_ ? "" : "\n") + PredictionText(prediction, marker_names_));
    }
    first_ = false;
  }

 private:
  const bool json_;
  const std::vector<std::string> marker_names_;
  bool first_ = true;
};

absl::Status Run(const PredictOptions& options, const GlobalOptions& global) {
  v1::PredictRequest request = Request(options);
  if (absl::Status status = SetQuery(options.query, request); !status.ok()) return status;
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  std::vector<std::string> marker_names;
  if (!global.json) {
    auto names = MarkerNames(*client, options.query.database);
    if (!names.ok()) return names.status();
    marker_names = *std::move(names);
  }
  Printer printer(global.json, std::move(marker_names));
  if (options.every_seconds) {
    v1::PredictSeriesRequest series;
    *series.mutable_prediction() = std::move(request);
    series.set_every_seconds(*options.every_seconds);
    return client->PredictSeries(series, [&](const v1::PredictSeriesResponse& response) {
      printer.Print(response.prediction());
      return absl::OkStatus();
    });
  }
  const auto response = client->Predict(request);
  if (!response.ok()) return response.status();
  printer.Print(*response);
  return absl::OkStatus();
}

}  // namespace

void AddPredictCommand(CommandLine line) {
  AddCommand<PredictOptions>(line, "predict", "Say what comes next, at one moment or at many",
                             Declare, Run);
}

}  // namespace motiondb::client
