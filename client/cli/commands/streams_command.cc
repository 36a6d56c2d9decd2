// motiondb streams list|watch: the running Observe streams of a database.
#include <fmt/format.h>
#include <motiondb/v1/observe.pb.h>

#include "client/cli/command.h"
#include "client/cli/database_text.h"
#include "client/cli/observe_replay.h"
#include "client/cli/query/query_options.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {
namespace {

struct StreamsListOptions {
  static constexpr bool kPrintsTable = true;
  std::string database;
};

struct StreamWatchOptions {
  std::string database;
  std::string stream;
  double unknown_threshold = kDefaultUnknownThreshold;
};

void DeclareStreamsList(CLI::App& command, StreamsListOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
}

void DeclareStreamWatch(CLI::App& command, StreamWatchOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("STREAM", options.stream, "Name in `motiondb streams list`")->required();
  AddUnknownThresholdOption(command, options.unknown_threshold);
  command.footer(
      "A line has the time of the newest frame, and the answer to it. Answers are left out if the "
      "output is slow. Ends when the stream ends; Ctrl-C ends.");
}

Table StreamsTable(const std::vector<v1::ObservedStream>& streams) {
  Table table({{"STREAM"},
               {"CALLER"},
               {"STARTED"},
               {"FRAME", Align::kRight},
               {"RATE (Hz)", Align::kRight},
               {"MARKERS", Align::kRight}});
  for (const v1::ObservedStream& stream : streams) {
    table.AddRow({ShortName(stream.name()), stream.caller(), TimeText(stream.start_time()),
                  Cell(stream.frame()), Cell(stream.frame_rate_hz(), 1),
                  Cell(stream.marker_names_size())});
  }
  return table;
}

absl::Status RunStreamsList(const StreamsListOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::ListStreamsRequest request;
  request.set_parent(DatabaseName(options.database));
  const auto response = client->ListStreams(request);
  if (!response.ok()) return response.status();
  PrintItems<v1::ObservedStream>({response->streams().begin(), response->streams().end()}, global,
                                 StreamsTable, "no running streams");
  return absl::OkStatus();
}

absl::Status RunStreamWatch(const StreamWatchOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::WatchStreamRequest request;
  request.set_name(StreamName(options.database, options.stream));
  double frame_rate_hz = 1;
  const auto print = [&](const v1::WatchStreamResponse& message) -> absl::Status {
    if (message.has_stream()) frame_rate_hz = message.stream().frame_rate_hz();
    if (global.json) {
      PrintJson(message);
    } else if (message.has_answer()) {
      const double seconds = static_cast<double>(message.answer().frame()) / frame_rate_hz;
      PrintLineText(
          Shortened(ObserveAnswerLine(message.answer(), seconds, options.unknown_threshold),
                    OutputSize().columns));
    }
    FlushOutput();
    return OutputFailed() ? absl::CancelledError("the output was closed") : absl::OkStatus();
  };
  const absl::Status ended = client->WatchStream(request, print);
  return OutputFailed() ? absl::OkStatus() : ended;
}

}  // namespace

void AddStreamsCommand(CommandLine line) {
  const CommandLine inner = AddCommandGroup(
      line, "streams", "List or watch the running streams of `motiondb observe` and of robots",
      "motiondb streams list walks\nmotiondb streams watch walks 3");
  AddCommand<StreamsListOptions>(inner, "list", "List the running streams, oldest first",
                                 "motiondb streams list walks --csv", DeclareStreamsList,
                                 RunStreamsList);
  AddCommand<StreamWatchOptions>(inner, "watch", "Print the answers of a stream as they happen",
                                 "motiondb streams watch walks 3 --json", DeclareStreamWatch,
                                 RunStreamWatch);
}

}  // namespace motiondb::client
