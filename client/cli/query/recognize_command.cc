// motiondb recognize DB FILE...: names the motion of each window.

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <utility>
#include <vector>

#include "client/cli/command.h"
#include "client/cli/database_text.h"
#include "client/cli/motion_file.h"
#include "client/cli/plot/picture_file.h"
#include "client/cli/plot/recognition_plot.h"
#include "client/cli/query/query_files.h"
#include "client/cli/query/query_options.h"
#include "client/cli/query/recognition_text.h"
#include "client/cli/terminal/print.h"
#include "client/output_file.h"

namespace motiondb::client {

namespace {

struct RecognizeOptions {
  static constexpr bool kPrintsTable = true;
  const CLI::App* command = nullptr;
  QueryOptions query;
  std::string track;
  std::string window = "0.4";
  double hop_seconds = 0.1;
  int top = 0;
  int paths = 0;
  v1::Method method = v1::METHOD_BEST;
  double unknown_threshold = kDefaultUnknownThreshold;
  bool every_window = false;
  std::string plot;
  std::string profile_plot;
};

std::string CheckWindow(const std::string& text) {
  double seconds = 0;
  if (text == "all" || (CLI::detail::lexical_cast(text, seconds) && seconds > 0)) return "";
  return "expected seconds or \"all\", found \"" + text + "\"";
}

void Declare(CLI::App& command, RecognizeOptions& options) {
  options.command = &command;
  AddQueryOptions(command, options.query);
  AddTrackOption(command, options.track);
  command.footer(
      "--layer, --floor and --paths need --method paper or --plot-profile; --unknown-threshold "
      "needs --method best.");
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
  command.add_flag(
      "--every-window", options.every_window,
      "Print every window; else successive windows with the same answer together, with "
      "the means of their probabilities and familiarities. --csv and --json always "
      "print every window");
  command
      .add_option("--plot", options.plot,
                  "Draw the answer over time: probabilities of labels and of unknown motion, best "
                  "clips, familiarity")
      ->type_name(kPictureFile);
  command
      .add_option("--plot-profile", options.profile_plot,
                  "Draw the generation probability of clips in each window, as in the paper, at "
                  "the bottom, a middle and an upper layer, or at --layer; needs a query for each "
                  "layer")
      ->type_name(kPictureFile);
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
  request.set_track(options.track);
  if (options.paths > 0) {
    request.set_generation(v1::GENERATION_TOP_PATHS);
    request.set_path_count(options.paths);
  }
  return request;
}

// Options and files that are wrong are found before the query.
absl::Status CheckOptions(const RecognizeOptions& options) {
  const bool is_best = options.method == v1::METHOD_BEST;
  absl::Status status;
  // The profile is made by the paper's method.
  if (is_best && options.profile_plot.empty()) {
    status = RejectOptions(*options.command, options.method, {"--layer", "--floor", "--paths"});
  } else if (!is_best) {
    status = RejectOptions(*options.command, options.method, {"--unknown-threshold"});
  }
  status.Update(CheckPictureFile("--plot", options.plot));
  status.Update(CheckPictureFile("--plot-profile", options.profile_plot));
  if (status.ok()) status = CheckCanWrite({options.plot, options.profile_plot});
  return status;
}

std::string Text(const v1::RecognizeResponse& response, const RecognizeOptions& options) {
  const std::string text =
      RecognitionText(response, options.unknown_threshold,
                      options.every_window ? Windows::kEvery : Windows::kMerged);
  // The paper's method has no probability of unknown motion, whatever the calibration is.
  return options.method == v1::METHOD_PAPER ? text : text + UnknownNote(response.calibration());
}

absl::Status WritePlots(const Client& client, const RecognizeOptions& options,
                        const v1::RecognizeRequest& request, const v1::RecognizeResponse& response,
                        bool reports) {
  if (!options.plot.empty()) {
    absl::Status status = WritePicture(
        options.plot, RecognitionPicture(request, response, options.unknown_threshold));
    if (!status.ok()) return status;
    if (reports) PrintLine("wrote {}", options.plot);
  }
  if (options.profile_plot.empty()) return absl::OkStatus();
  std::vector<int> layers;
  if (options.query.layer > 0) layers.push_back(options.query.layer);
  const auto picture = AskForProfile(client, request, layers);
  if (!picture.ok()) return picture.status();
  absl::Status status = WritePicture(options.profile_plot, *picture);
  if (status.ok() && reports) PrintLine("wrote {}", options.profile_plot);
  return status;
}

absl::Status Run(const RecognizeOptions& options, const GlobalOptions& global) {
  if (absl::Status status = CheckOptions(options); !status.ok()) return status;
  v1::RecognizeRequest request = Request(options);
  SetQuery(options.query, request);
  const auto ask = [&](const Client& client, QueriedFile& file) -> absl::Status {
    *request.mutable_observation() = file.TakeObservation();
    const auto response = client.Recognize(request);
    if (!response.ok()) return response.status();
    file.Print(
        *response, [&] { return Text(*response, options); },
        [&] { return RecognitionTable(*response, options.unknown_threshold, Windows::kEvery); });
    return WritePlots(client, options, request, *response, !global.json && !global.csv);
  };
  const bool has_plots = !options.plot.empty() || !options.profile_plot.empty();
  return AskForFiles(options.query, global, ask, has_plots ? "--plot and --plot-profile" : "");
}

}  // namespace

void AddRecognizeCommand(CommandLine line) {
  AddCommand<RecognizeOptions>(
      line, "recognize", "Name the motion of each window of a file",
      "motiondb recognize walks observed.bvh\n"
      "motiondb recognize walks recordings/ --csv --output answers.csv\n"
      "motiondb recognize walks observed.bvh --window all --plot answer.svg\n"
      "motiondb recognize walks observed.bvh --method paper --layer 6\n"
      "motiondb recognize walks observed.bvh --filter 'subject != \"07\"'",
      Declare, Run);
}

}  // namespace motiondb::client
