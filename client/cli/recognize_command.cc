// motiondb recognize DB FILE: what is this motion?
#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include "client/cli/command.h"
#include "client/cli/json_output.h"
#include "client/cli/query_options.h"
#include "client/cli/recognition_text.h"

namespace motiondb::client {
namespace {

struct RecognizeOptions {
  QueryOptions query;
  std::string window = "0.4";
  double hop_seconds = 0.1;
  int top = 0;
  int paths = 0;
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
  if (options.paths > 0) {
    request.set_generation(v1::GENERATION_TOP_PATHS);
    request.set_path_count(options.paths);
  }
  return request;
}

absl::Status Run(const RecognizeOptions& options, const GlobalOptions& global) {
  v1::RecognizeRequest request = Request(options);
  if (absl::Status status = SetQuery(options.query, request); !status.ok()) return status;
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto response = client->Recognize(request);
  if (!response.ok()) return response.status();
  if (global.json) {
    PrintJson(*response);
  } else {
    fmt::print("{}", RecognitionText(*response));
  }
  return absl::OkStatus();
}

}  // namespace

void AddRecognizeCommand(CommandLine line) {
  AddCommand<RecognizeOptions>(line, "recognize", "Say what a motion is, window by window", Declare,
                               Run);
}

}  // namespace motiondb::client
