// motiondb find DB FILE...: the stored parts that are most similar to a motion.
#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <optional>
#include <string>

#include "client/cli/command.h"
#include "client/cli/plan_request.h"
#include "client/cli/query/query_files.h"
#include "client/cli/query/query_options.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {

namespace {

struct FindOptions {
  static constexpr bool kPrintsTable = true;
  QueryOptions query;
  std::optional<double> from_seconds;
  std::optional<double> to_seconds;
  std::string clip;  // "CLIP@A-B"
  int top = 10;
  bool exhaustive = false;
};

// Parses "CLIP@A-B". The clip is a short or a full name.
std::optional<v1::ClipRange> ParseClipRange(const std::string& text) {
  const std::size_t at = text.rfind('@');
  const std::size_t dash = text.find('-', at == std::string::npos ? at : at + 1);
  if (at == 0 || dash == std::string::npos) return std::nullopt;
  const auto start = ParseNumbers(text.substr(at + 1, dash - at - 1));
  const auto end = ParseNumbers(text.substr(dash + 1));
  if (!start || !end || start->size() != 1 || end->size() != 1) return std::nullopt;
  if (start->front() < 0 || end->front() <= start->front()) return std::nullopt;
  v1::ClipRange range;
  range.set_clip(text.substr(0, at));
  range.set_start_seconds(start->front());
  range.set_end_seconds(end->front());
  return range;
}

std::string CheckClipRange(const std::string& text) {
  return ParseClipRange(text) ? ""
                              : fmt::format("expected CLIP@A-B, as in 07_01@1.5-3, got {}", text);
}

void Declare(CLI::App& command, FindOptions& options) {
  AddOptionalFileOptions(command, options.query);
  CLI::Option* const from = command.add_option("--from", options.from_seconds,
                                               "Start of the part of the motion to find; else its "
                                               "start");
  from->type_name("SECONDS")->check(NonNegativeNumber());
  CLI::Option* const to = command.add_option("--to", options.to_seconds,
                                             "End of the part of the motion to find; else its end");
  to->type_name("SECONDS")->check(PositiveNumber());
  command
      .add_option("--clip", options.clip,
                  "Find this part of a stored clip, from A to B seconds, instead of files")
      ->type_name("CLIP@A-B")
      ->check(CheckClipRange)
      ->excludes(from)
      ->excludes(to);
  command.add_option("--top", options.top, "Maximum number of matches")
      ->type_name("K")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command.add_flag("--exhaustive", options.exhaustive,
                   "Compare all clips; else those that are probably similar, which is faster and "
                   "may miss matches");
  command.footer(
      "SCORE is 1 for the same motion, and 0.5 for a difference as large as the mean one "
      "between motions of one label.");
}

Table MatchTable(const v1::FindResponse& response) {
  Table table(
      {{"CLIP"}, {"FROM (s)", Align::kRight}, {"TO (s)", Align::kRight}, {"SCORE", Align::kRight}});
  for (const v1::FindMatch& match : response.matches()) {
    table.AddRow({ShortName(match.clip()), Cell(match.start_seconds(), 2),
                  Cell(match.end_seconds(), 2), Cell(match.score(), 3)});
  }
  return table;
}

absl::Status AskFor(const Client& client, const v1::FindRequest& request, QueriedFile& file) {
  const auto response = client.Find(request);
  if (!response.ok()) return response.status();
  const auto table = [&] { return MatchTable(*response); };
  file.Print(
      *response, [&] { return table().ToString(); }, table);
  return absl::OkStatus();
}

absl::Status AskForClip(const FindOptions& options, const GlobalOptions& global,
                        v1::FindRequest& request) {
  v1::ClipRange& range = *request.mutable_clip_range();
  range = *ParseClipRange(options.clip);
  range.set_clip(ClipName(options.query.database, range.clip()));
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  bool is_first = true;
  QueriedFile clip(global, "", {}, is_first);
  return AskFor(*client, request, clip);
}

absl::Status Run(const FindOptions& options, const GlobalOptions& global) {
  if (options.query.files.empty() == options.clip.empty()) {
    return UsageError("expected FILE or --clip CLIP@A-B, one of them");
  }
  v1::FindRequest request;
  request.set_database(DatabaseName(options.query.database));
  request.set_filter(options.query.filter);
  request.set_min_revision(options.query.min_revision);
  request.set_top_count(options.top);
  request.set_exhaustive(options.exhaustive);
  if (!options.clip.empty()) return AskForClip(options, global, request);
  if (options.from_seconds) request.set_start_seconds(*options.from_seconds);
  if (options.to_seconds) request.set_end_seconds(*options.to_seconds);
  return AskForFiles(options.query, global, [&](const Client& client, QueriedFile& file) {
    *request.mutable_observation() = file.TakeObservation();
    return AskFor(client, request, file);
  });
}

}  // namespace

void AddFindCommand(CommandLine line) {
  AddCommand<FindOptions>(line, "find", "Find the stored parts that are most similar to a motion",
                          "motiondb find walks observed.bvh --from 1.5 --to 3\n"
                          "motiondb find walks --clip 07_01@1.5-3 --filter 'label != \"walk\"'\n"
                          "motiondb find walks recordings/ --top 3 --csv --output matches.csv",
                          Declare, Run);
}

}  // namespace motiondb::client
