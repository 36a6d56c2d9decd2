// motiondb create, list, describe and delete.

#include <fmt/format.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/operation.pb.h>
#include <unistd.h>

#include <iostream>

#include "client/cli/command.h"
#include "client/cli/database_text.h"
#include "client/cli/motion_file.h"
#include "client/cli/rebuild_wait.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"
#include "text/display_text.h"

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

// motiondb list [DB]

namespace {

struct ListOptions {
  static constexpr bool kPrintsTable = true;
  std::string database;
};

void Declare(CLI::App& command, ListOptions& options) {
  command.add_option("DB", options.database, "Database whose clips are listed; else all databases");
}

absl::Status Run(const ListOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  if (options.database.empty()) {
    const auto databases = client->AllDatabases();
    if (!databases.ok()) return databases.status();
    PrintItems(*databases, global, DatabasesTable,
               "no databases; create one with `motiondb create DB`");
    return absl::OkStatus();
  }
  v1::ListClipsRequest request;
  request.set_parent(DatabaseName(options.database));
  request.set_page_size(1000);
  const auto clips = client->AllClips(request);
  if (!clips.ok()) return clips.status();
  PrintItems(*clips, global, ClipsTable, "no clips; add some with `motiondb ingest DB FILE...`");
  if (!global.json && !global.csv) PrintText(UnderivedText(*clips));
  return absl::OkStatus();
}

}  // namespace

void AddListCommand(CommandLine line) {
  AddCommand<ListOptions>(line, "list", "List all databases, or the clips of a database",
                          "motiondb list\n"
                          "motiondb list walks --csv --output clips.csv",
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

// motiondb delete DB [CLIP]

namespace {

struct DeleteOptions {
  std::string database;
  std::string clip;
  bool yes = false;
};

void Declare(CLI::App& command, DeleteOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("CLIP", options.clip, "Clip to delete; else the whole database");
  command.add_flag("--yes", options.yes,
                   "Do not ask before a whole database is deleted. If standard input is not a "
                   "terminal, as in a script, it never asks");
}

// On a terminal, asks the user to type the name of the database. Scripts are not asked.
absl::Status Confirm(const std::string& name) {
  if (isatty(STDIN_FILENO) != 1) return absl::OkStatus();
  fmt::print(stderr, "This deletes all clips and models of {0}. Type {0} to continue: ",
             text::SafeText(name));
  std::fflush(stderr);
  std::string typed;
  std::getline(std::cin, typed);
  if (typed == name) return absl::OkStatus();
  return absl::CancelledError(fmt::format("{} was not deleted", name));
}

absl::Status DeleteDatabase(const DeleteOptions& options, const GlobalOptions& global) {
  const std::string name = DatabaseName(options.database);
  if (!options.yes) {
    if (const absl::Status status = Confirm(ShortName(name)); !status.ok()) return status;
  }
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::DeleteDatabaseRequest request;
  request.set_name(name);
  const auto response = client->DeleteDatabase(request);
  if (!response.ok()) return response.status();
  if (global.json) {
    PrintJson(*response);
  } else {
    PrintLine("deleted database {}", ShortName(name));
  }
  return absl::OkStatus();
}

absl::Status DeleteClip(const DeleteOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::DeleteClipRequest request;
  request.set_name(ClipName(options.database, options.clip));
  auto response = client->DeleteClip(request);
  if (!response.ok()) return response.status();
  auto done = WaitForRebuild(*client, response->operation().name(), "the clip is deleted");
  if (!done.ok()) return done.status();
  if (global.json) {
    *response->mutable_operation() = *std::move(done);
    PrintJson(*response);
    return absl::OkStatus();
  }
  const auto summary = ModelSummary(*client, *done);
  if (!summary.ok()) return summary.status();
  PrintLine("deleted clip {}; {}", ShortName(request.name()), *summary);
  return absl::OkStatus();
}

absl::Status Run(const DeleteOptions& options, const GlobalOptions& global) {
  return options.clip.empty() ? DeleteDatabase(options, global) : DeleteClip(options, global);
}

}  // namespace

void AddDeleteCommand(CommandLine line) {
  AddCommand<DeleteOptions>(line, "delete",
                            "Delete a clip and wait for the new model, or delete a whole database",
                            "motiondb delete walks 07_01\n"
                            "motiondb delete walks --yes",
                            Declare, Run);
}

}  // namespace motiondb::client
