// motiondb create DB: an empty database.
#include <fmt/format.h>
#include <motiondb/v1/database.pb.h>

#include <filesystem>

#include "client/cli/command.h"
#include "client/cli/database_text.h"
#include "client/cli/json_output.h"
#include "client/cli/motion_file.h"
#include "client/cli/print.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {
namespace {

struct CreateOptions {
  std::string database;
  double frame_rate_hz = 60;
  int min_frames = 16;
  std::string scaling = "kind";
  std::string marker_set = "standard34";
};

void Declare(CLI::App& command, CreateOptions& options) {
  command.add_option("DB", options.database, "Name of the new database")->required();
  command.add_option("--frame-rate", options.frame_rate_hz, "Frame rate of all stored states")
      ->type_name("HZ")
      ->check(PositiveNumber())
      ->capture_default_str();
  command.add_option("--min-frames", options.min_frames, "The fewest frames that a node may have")
      ->type_name("N")
      ->check(PositiveNumber())
      ->capture_default_str();
  command
      .add_option("--scaling", options.scaling,
                  "What features are divided by: nothing, one scale for positions and one for "
                  "velocities, or each dimension's own")
      ->type_name("none|kind|dimension")
      ->check(CLI::IsMember({"none", "kind", "dimension"}))
      ->capture_default_str();
  command
      .add_option(
          "--marker-set", options.marker_set,
          "standard34, source (the first clip's own markers or joints), or a marker-set file")
      ->type_name("standard34|source|FILE")
      ->capture_default_str();
}

v1::Scaling ScalingOf(const std::string& word) {
  if (word == "none") return v1::SCALING_NONE;
  if (word == "dimension") return v1::SCALING_DIMENSION;
  return v1::SCALING_KIND;
}

absl::Status SetMarkerSet(const std::string& given, v1::Database& database) {
  if (given == "standard34" || given == "source") {
    database.set_marker_set(given);
    return absl::OkStatus();
  }
  auto text = ReadFileBytes(given);
  if (!text.ok()) {
    return absl::Status(text.status().code(),
                        fmt::format("--marker-set: expected standard34, source or a file; {}",
                                    std::string(text.status().message())));
  }
  database.set_marker_set(std::filesystem::path(given).stem().string());
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
  AddCommand<CreateOptions>(line, "create", "Create an empty database", Declare, Run);
}

}  // namespace motiondb::client
