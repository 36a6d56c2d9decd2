// motiondb recognize, estimate and predict.

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <optional>
#include <utility>
#include <vector>

#include "client/cli/answer_text.h"
#include "client/cli/command.h"
#include "client/cli/database_text.h"
#include "client/cli/motion_file.h"
#include "client/cli/print.h"
#include "client/cli/query_options.h"
#include "client/cli/recognition_plot.h"
#include "client/cli/recognition_plot_profile.h"
#include "client/output_file.h"

namespace motiondb::client {

namespace {

struct RecognizeOptions {
  QueryOptions query;
  std::string window = "0.4";
  double hop_seconds = 0.1;
  int top = 0;
  int paths = 0;
  v1::Method method = v1::METHOD_BEST;
  double unknown_threshold = kDefaultUnknownThreshold;
  std::string plot;
  std::string profile_plot;
};

std::string CheckWindow(const std::string& text) {
  double seconds = 0;
  if (text == "all" || (CLI::detail::lexical_cast(text, seconds) && seconds > 0)) return "";
  return "expected seconds or \"all\", found \"" + text + "\"";
}

void Declare(CLI::App& command, RecognizeOptions& options) {
  AddQueryOptions(command, options.query);
  command
      .add_option("--window", options.window, "Width of the sliding window, or all of the motion")
      ->type_name("SECONDS|all")
      ->check(CheckWindow)
      ->capture_default_str();
  command.add_option("--hop", options.hop_seconds, "Distance between windows")
      ->type_name("SECONDS")
      ->check(PositiveNumber())
      ->capture_default_str();
  command.add_option("--top", options.top, "Maximum number of clips per window; else all")
      ->type_name("K")
      ->check(PositiveNumber());
  command
      .add_option("--paths", options.paths,
                  "Sum only the K best paths, as in the paper; else all paths")
      ->type_name("K")
      ->check(PositiveNumber());
  AddMethodOption(command, options.method);
  AddUnknownThresholdOption(command, options.unknown_threshold);
  command
      .add_option("--plot", options.plot,
                  "Draw the answer over time: probabilities of labels and of unknown motion, best "
                  "clips, familiarity")
      ->type_name("FILE.svg");
  command
      .add_option("--plot-profile", options.profile_plot,
                  "Draw the generation probability of clips in each window, as in the paper, at "
                  "the bottom, a middle and an upper layer, or at --layer; needs a query for each "
                  "layer")
      ->type_name("FILE.svg");
}

v1::RecognizeRequest Request(const RecognizeOptions& options) {
  v1::RecognizeRequest request;
  if (options.window == "all") {
    request.set_whole(true);
  } else {
    request.set_window_seconds(std::stod(options.window));
  }
  request.set_hop_seconds(options.hop_seconds);
  if (options.top > 0) request.set_top_count(options.top);
  request.set_method(options.method);
  if (options.paths > 0) {
    request.set_generation(v1::GENERATION_TOP_PATHS);
    request.set_path_count(options.paths);
  }
  return request;
}

absl::Status CheckPlotFile(const char* option, const std::string& file) {
  if (file.empty() || HasExtension(file, ".svg")) return absl::OkStatus();
  return absl::InvalidArgumentError(fmt::format("{} {}: expected FILE.svg", option, file));
}

// Queries all clips at each layer by the paper's method, and draws the answers.
absl::Status WriteProfilePlot(const Client& client, const RecognizeOptions& options,
                              v1::RecognizeRequest request) {
  request.clear_top_count();
  request.set_method(v1::METHOD_PAPER);
  std::vector<v1::RecognizeResponse> layers;
  const auto ask = [&](int layer) {
    if (layer > 0) request.set_layer(layer);
    auto response = client.Recognize(request);
    if (!response.ok()) return response.status();
    layers.push_back(*std::move(response));
    return absl::OkStatus();
  };
  absl::Status status = ask(options.query.layer);
  if (status.ok() && options.query.layer == 0 && layers[0].windows_size() > 0) {
    for (const int layer : PlottedLayers(layers[0].windows(0).layer())) {
      if (status = ask(layer); !status.ok()) break;
    }
  }
  if (!status.ok()) return status;
  request.clear_layer();
  if (options.query.layer > 0) request.set_layer(options.query.layer);
  return WriteFileAtomically(options.profile_plot, ProfilePlotSvg(request, layers));
}

absl::Status Run(const RecognizeOptions& options, const GlobalOptions& global) {
  absl::Status status = CheckPlotFile("--plot", options.plot);
  status.Update(CheckPlotFile("--plot-profile", options.profile_plot));
  v1::RecognizeRequest request = Request(options);
  if (status.ok()) status = SetQuery(options.query, request);
  if (!status.ok()) return status;
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto response = client->Recognize(request);
  if (!response.ok()) return response.status();
  if (global.json) {
    PrintJson(*response);
  } else {
    PrintText(RecognitionText(*response, options.unknown_threshold));
    // The paper's method has no probability of unknown motion, whatever the calibration is.
    if (options.method != v1::METHOD_PAPER) PrintText(UnknownNote(response->calibration()));
  }
  const auto report = [&](const std::string& file) {
    if (status.ok() && !global.json) PrintLine("wrote {}", file);
  };
  if (!options.plot.empty()) {
    status = WriteFileAtomically(options.plot,
                                 RecognitionPlotSvg(request, *response, options.unknown_threshold));
    report(options.plot);
  }
  if (status.ok() && !options.profile_plot.empty()) {
    status = WriteProfilePlot(*client, options, std::move(request));
    report(options.profile_plot);
  }
  return status;
}

}  // namespace

void AddRecognizeCommand(CommandLine line) {
  AddCommand<RecognizeOptions>(line, "recognize", "Name the motion of each window of a file",
                               Declare, Run);
}

// motiondb estimate DB FILE

namespace {

struct EstimateOptions {
  QueryOptions query;
  int paths = 1;
  std::optional<int> max_candidates;
  bool fill_every_frame = false;
};

void Declare(CLI::App& command, EstimateOptions& options) {
  AddQueryOptions(command, options.query);
  command.add_option("--paths", options.paths, "Number of node paths, best first")
      ->type_name("K")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command
      .add_option("--max-candidates", options.max_candidates,
                  "Candidates per frame and layer; else 16; 0 keeps all (exact)")
      ->type_name("N")
      ->check(NonNegativeNumber());
  command.add_flag("--fill-every-frame", options.fill_every_frame,
                   "Fill in missing markers in every frame; else only in the last");
}

absl::Status Run(const EstimateOptions& options, const GlobalOptions& global) {
  v1::EstimateRequest request;
  if (absl::Status status = SetQuery(options.query, request); !status.ok()) return status;
  request.set_path_count(options.paths);
  if (options.max_candidates) request.set_max_candidates(*options.max_candidates);
  request.set_fill_every_frame(options.fill_every_frame);
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto response = client->Estimate(request);
  if (!response.ok()) return response.status();
  if (global.json) {
    PrintJson(*response);
  } else {
    std::vector<std::string> marker_names;
    if (response->filled_frames_size() > 0) {
      auto names = MarkerNames(*client, options.query.database);
      if (!names.ok()) return names.status();
      marker_names = *std::move(names);
    }
    PrintText(EstimationText(*response, marker_names));
  }
  return absl::OkStatus();
}

}  // namespace

void AddEstimateCommand(CommandLine line) {
  AddCommand<EstimateOptions>(line, "estimate", "Estimate the node paths of a motion", Declare,
                              Run);
}

// motiondb predict DB FILE

namespace {

struct PredictOptions {
  QueryOptions query;
  v1::Method method = v1::METHOD_BEST;
  std::optional<double> at_seconds;
  std::optional<double> every_seconds;
  double history_seconds = 0.4;
  std::vector<double> horizon_seconds = {0.08, 0.16, 0.32, 0.4, 0.56, 1.0};
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

// Prints predictions when they arrive.
class Printer {
 public:
  Printer(bool json, std::vector<std::string> marker_names, double unknown_threshold)
      : json_(json),
        marker_names_(std::move(marker_names)),
        unknown_threshold_(unknown_threshold) {}

  void Print(const v1::PredictResponse& prediction) {
    if (json_) {
      PrintJson(prediction);
    } else {
      PrintText((first_ ? "" : "\n") +
                PredictionText(prediction, marker_names_, unknown_threshold_));
    }
    first_ = false;
  }

 private:
  const bool json_;
  const std::vector<std::string> marker_names_;
  const double unknown_threshold_;
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
  Printer printer(global.json, std::move(marker_names), options.unknown_threshold);
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
  AddCommand<PredictOptions>(line, "predict", "Predict the motion from one or many times of a file",
                             Declare, Run);
}

}  // namespace motiondb::client
