// motiondb recognize DB FILE: what is this motion?
#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <utility>
#include <vector>

#include "client/cli/command.h"
#include "client/cli/json_output.h"
#include "client/cli/motion_file.h"
#include "client/cli/print.h"
#include "client/cli/query_options.h"
#include "client/cli/recognition_plot.h"
#include "client/cli/recognition_text.h"
#include "client/cli/whole_file.h"

namespace motiondb::client {
namespace {

struct RecognizeOptions {
  QueryOptions query;
  std::string window = "0.4";
  double hop_seconds = 0.1;
  int top = 0;
  int paths = 0;
  v1::Method method = v1::BEST;
  std::string plot;
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
  command.add_option("--hop", options.hop_seconds, "How far the window moves each time")
      ->type_name("SECONDS")
      ->check(PositiveNumber())
      ->capture_default_str();
  command.add_option("--top", options.top, "At most this many clips a window; else all")
      ->type_name("K")
      ->check(PositiveNumber());
  command
      .add_option("--paths", options.paths,
                  "Sum the K best paths, as in the paper; else all paths, exactly")
      ->type_name("K")
      ->check(PositiveNumber());
  AddMethodOption(command, options.method);
  command
      .add_option("--plot", options.plot,
                  "Draw how probable each clip's graph makes each window, at the bottom, a middle "
                  "and an upper layer, or at that of --layer; asks once more for each")
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
  request.set_top_count(options.top);
  request.set_method(options.method);
  if (options.paths > 0) {
    request.set_generation(v1::GENERATION_TOP_PATHS);
    request.set_path_count(options.paths);
  }
  return request;
}

absl::Status CheckFiles(const RecognizeOptions& options) {
  if (options.plot.empty() || HasExtension(options.plot, ".svg")) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("--plot {}: the profiles are drawn as FILE.svg", options.plot));
}

// Asks again, for all clips under the graphs of each layer, and draws the answers.
absl::Status WritePlot(const Client& client, const RecognizeOptions& options,
                       v1::RecognizeRequest& request) {
  request.set_top_count(0);
  request.set_method(v1::PAPER);
  std::vector<v1::RecognizeResponse> layers;
  const auto ask = [&](int layer) {
    request.set_layer(layer);
    auto response = client.Recognize(request);
    if (response.ok()) layers.push_back(*std::move(response));
    return response.status();
  };
  absl::Status status = ask(options.query.layer);
  if (status.ok() && options.query.layer == 0 && layers[0].windows_size() > 0) {
    for (const int layer : LayersAbove(layers[0].windows(0).layer())) {
      if (status = ask(layer); !status.ok()) break;
    }
  }
  if (!status.ok()) return status;
  request.set_layer(options.query.layer);
  return WriteWholeFile(options.plot, RecognitionPlotSvg(request, layers));
}

absl::Status Run(const RecognizeOptions& options, const GlobalOptions& global) {
  if (absl::Status status = CheckFiles(options); !status.ok()) return status;
  v1::RecognizeRequest request = Request(options);
  if (absl::Status status = SetQuery(options.query, request); !status.ok()) return status;
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto response = client->Recognize(request);
  if (!response.ok()) return response.status();
  if (global.json) {
    PrintJson(*response);
  } else {
    PrintText(RecognitionText(*response));
  }
  if (options.plot.empty()) return absl::OkStatus();
  absl::Status status = WritePlot(*client, options, request);
  if (status.ok() && !global.json) PrintLine("wrote {}", options.plot);
  return status;
}

}  // namespace

void AddRecognizeCommand(CommandLine line) {
  AddCommand<RecognizeOptions>(line, "recognize", "Say what a motion is, window by window", Declare,
                               Run);
}

}  // namespace motiondb::client
