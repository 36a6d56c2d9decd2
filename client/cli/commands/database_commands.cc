// motiondb create, describe and reprocess.
#include <fmt/format.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/operation.pb.h>

#include "client/cli/command.h"
#include "client/cli/database_text.h"
#include "client/cli/motion_file.h"
#include "client/cli/rebuild_wait.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {

namespace {

struct CreateOptions {
  std::string database;
  double frame_rate_hz = 60;
  int min_frames = 16;
  std::string scaling = "kind";
  std::string marker_set = "standard34";
  std::string glitches = "repair";
};

void Declare(CLI::App& command, CreateOptions& options) {
  command.add_option("DB", options.database, "Name of the new database")->required();
  command.add_option("--frame-rate", options.frame_rate_hz, "Frame rate of all stored states")
      ->type_name("HZ")
      ->check(PositiveNumber())
      ->capture_default_str();
  command.add_option("--min-frames", options.min_frames, "Minimum number of frames of a node")
      ->type_name("N")
      ->check(PositiveNumber())
      ->capture_default_str();
  command
      .add_option("--scaling", options.scaling,
                  "Divisor of features: none, one for positions and one for velocities, or one "
                  "for each dimension")
      ->type_name("none|kind|dimension")
      ->check(CLI::IsMember({"none", "kind", "dimension"}))
      ->capture_default_str();
  command
      .add_option(
          "--marker-set", options.marker_set,
          "standard34, source (the first clip's own markers or joints), or a marker-set file")
      ->type_name("standard34|source|FILE")
      ->capture_default_str();
  command
      .add_option(
          "--glitches", options.glitches,
          "Clips with glitches: interpolate up to 0.25 s and refuse longer ones, refuse all, store "
          "the longest part without glitches, or store unchanged")
      ->type_name("repair|reject|drop|keep")
      ->check(CLI::IsMember({"repair", "reject", "drop", "keep"}))
      ->capture_default_str();
}

v1::Scaling ScalingOf(const std::string& word) {
  if (word == "none") return v1::SCALING_NONE;
  if (word == "dimension") return v1::SCALING_DIMENSION;
  return v1::SCALING_KIND;
}

v1::Glitches GlitchesOf(const std::string& word) {
  if (word == "reject") return v1::GLITCHES_REJECT;
  if (word == "drop") return v1::GLITCHES_DROP;
  if (word == "keep") return v1::GLITCHES_KEEP;
  return v1::GLITCHES_REPAIR;
}

absl::Status SetMarkerSet(const std::string& given, v1::Database& database) {
  if (given == "standard34" || given == "source") {
    database.set_marker_set(given);
    return absl::OkStatus();
  }
  auto text = ReadTextFile(given);
  if (!text.ok()) {
    const std::string message =
        fmt::format("--marker-set: expected standard34, source or a file; {}",
                    std::string(text.status().message()));
    return absl::IsNotFound(text.status()) ? UsageError(message)
                                           : absl::Status(text.status().code(), message);
  }
  database.set_marker_set_file(*std::move(text));
  return absl::OkStatus();
}

absl::Status Run(const CreateOptions& options, const GlobalOptions& global) {
  v1::CreateDatabaseRequest request;
  const std::string name = DatabaseName(options.database);
  request.set_database_id(name.substr(name.find('/') + 1));
  v1::Database& database = *request.mutable_database();
  database.set_frame_rate_hz(options.frame_rate_hz);
  database.set_min_frames(options.min_frames);
  database.set_scaling(ScalingOf(options.scaling));
  database.set_glitches(GlitchesOf(options.glitches));
  if (const absl::Status status = SetMarkerSet(options.marker_set, database); !status.ok()) {
    return status;
  }
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto response = client->CreateDatabase(request);
  if (!response.ok()) return response.status();
  if (global.json) {
    PrintJson(*response);
  } else {
    PrintText("created\n" + DatabaseText(response->database()));
  }
  return absl::OkStatus();
}

}  // namespace

void AddCreateCommand(CommandLine line) {
  AddCommand<CreateOptions>(line, "create", "Create an empty database",
                            "motiondb create walks\n"
                            "motiondb create robots --frame-rate 120 --marker-set source",
                            Declare, Run);
}

// motiondb describe DB

namespace {

struct DescribeOptions {
  std::string database;
};

void Declare(CLI::App& command, DescribeOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
}

absl::Status Run(const DescribeOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::GetDatabaseRequest request;
  request.set_name(DatabaseName(options.database));
  request.set_view(v1::DATABASE_VIEW_FULL);
  const auto response = client->GetDatabase(request);
  if (!response.ok()) return response.status();
  const v1::DatabaseStatistics& statistics = response->database().statistics();
  if (global.json) {
    PrintJson(statistics);
  } else {
    PrintText(DescriptionText(statistics));
  }
  return absl::OkStatus();
}

}  // namespace

void AddDescribeCommand(CommandLine line) {
  AddCommand<DescribeOptions>(line, "describe", "Show a database's frames, clips, layers and nodes",
                              "motiondb describe walks", Declare, Run);
}

// motiondb reprocess: derives the stored clips again from their files.

namespace {

struct ReprocessOptions {
  std::string database;
};

void Declare(CLI::App& command, ReprocessOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.footer(
      "Reads the ingested files again with the current version of the server, and waits for the "
      "new model. After an upgrade the server does this itself if necessary. A clip that cannot be "
      "derived stays unchanged; `motiondb describe DB` shows why. If this command is interrupted, "
      "the server continues; `motiondb operations` shows and cancels the operation.");
}

absl::Status Run(const ReprocessOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::ReprocessDatabaseRequest request;
  request.set_name(DatabaseName(options.database));
  auto response = client->ReprocessDatabase(request);
  if (!response.ok()) return response.status();
  auto done = WaitForRebuild(*client, response->operation().name(),
                             "clips that were derived again keep their new states");
  if (!done.ok()) return done.status();
  if (global.json) {
    *response->mutable_operation() = *std::move(done);
    PrintJson(*response);
    return absl::OkStatus();
  }
  const auto summary = ModelSummary(*client, *done);
  if (!summary.ok()) return summary.status();
  v1::GetDatabaseRequest get;
  get.set_name(request.name());
  get.set_view(v1::DATABASE_VIEW_FULL);
  const auto database = client->GetDatabase(get);
  if (!database.ok()) return database.status();
  PrintLine("reprocessed {}: {}; {}", ShortName(request.name()), done->stage(), *summary);
  PrintText(UnderivedText(database->database().statistics()));
  return absl::OkStatus();
}

}  // namespace

void AddReprocessCommand(CommandLine line) {
  AddCommand<ReprocessOptions>(
      line, "reprocess", "Derive the stored clips again from their files, and rebuild the model",
      "motiondb reprocess walks", Declare, Run);
}

}  // namespace motiondb::client
