#include "client/cli/query/query_options.h"

#include <fmt/format.h>
#include <motiondb/v1/database.pb.h>

#include <map>
#include <string>

#include "client/cli/command.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {

namespace {

CLI::Option* AddDatabaseAndFiles(CLI::App& command, QueryOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  return command.add_option(
      "FILE", options.files,
      "Motion files, folders (all motion files below them), glob patterns, or - for paths on "
      "standard input, one per line");
}

void AddFileOptions(CLI::App& command, QueryOptions& options) {
  AddSourceOptions(command, options.source);
  AddForceOption(command, options.source);
}

void AddOptionsAfterFiles(CLI::App& command, QueryOptions& options) {
  AddFileOptions(command, options);
  command.add_option("--layer", options.layer, "Layer of the tree, from 1; else the bottom layer")
      ->type_name("N")
      ->check(PositiveNumber());
  command
      .add_option("--floor", options.floor,
                  "Probability of a transition without stored counts; else 1e-6; 0 forbids it")
      ->type_name("P")
      ->check(CLI::Range(0.0, 1.0));
  AddSelectionOptions(command, options.filter, options.min_revision);
}

}  // namespace

void AddSelectionOptions(CLI::App& command, std::string& filter, std::int64_t& min_revision) {
  AddFilterOption(
      command, filter,
      "Use only clips that pass this filter, as if the others were not in the database");
  command
      .add_option("--min-revision", min_revision,
                  "Wait until the model contains this revision of the database, at most for "
                  "--timeout")
      ->type_name("R")
      ->check(NonNegativeNumber());
}

void AddTrackOption(CLI::App& command, std::string& track) {
  command.add_option("--track", track, "Track of the labels; else action")->type_name("T");
}

void AddQueryOptions(CLI::App& command, QueryOptions& options) {
  AddDatabaseAndFiles(command, options)->required();
  AddOptionsAfterFiles(command, options);
}

void AddOptionalFileOptions(CLI::App& command, QueryOptions& options) {
  AddDatabaseAndFiles(command, options);
  AddFileOptions(command, options);
  AddSelectionOptions(command, options.filter, options.min_revision);
}

void AddQueryOptionsOfOneFile(CLI::App& command, QueryOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("FILE", options.files, "Motion file")->required()->expected(1);
  AddOptionsAfterFiles(command, options);
}

absl::Status RejectOptions(const CLI::App& command, v1::Method method,
                           std::initializer_list<const char*> names) {
  const bool is_paper = method == v1::METHOD_PAPER;
  for (const char* const name : names) {
    if (command.get_option(name)->count() == 0) continue;
    return UsageError(fmt::format("{} has no effect with --method {}; it needs --method {}", name,
                                  is_paper ? "paper" : "best", is_paper ? "best" : "paper"));
  }
  return absl::OkStatus();
}

void AddMethodOption(CLI::App& command, v1::Method& method) {
  const std::map<std::string, v1::Method> methods = {{"best", v1::METHOD_BEST},
                                                     {"paper", v1::METHOD_PAPER}};
  command
      .add_option_function<std::string>(
          "--method", [&method, methods](const std::string& word) { method = methods.at(word); },
          "best: most accurate, also compares stored frames; paper: only the tree and its graphs")
      ->type_name("METHOD")
      ->check(CLI::IsMember(methods))
      ->default_str("best");
}

void AddUnknownThresholdOption(CLI::App& command, double& threshold) {
  command
      .add_option("--unknown-threshold", threshold,
                  "Call motion unknown if its probability of unknown motion is greater; does not "
                  "change the output of --json")
      ->type_name("P")
      ->check(CLI::Range(0.0, 1.0))
      ->check(NonNegativeNumber())  // the range alone accepts NaN
      ->capture_default_str();
}

absl::StatusOr<std::vector<std::string>> MarkerNames(const Client& client,
                                                     const std::string& database) {
  v1::GetDatabaseRequest request;
  request.set_name(DatabaseName(database));
  const auto response = client.GetDatabase(request);
  if (!response.ok()) return response.status();
  const auto& names = response->database().marker_names();
  return std::vector<std::string>(names.begin(), names.end());
}

}  // namespace motiondb::client
