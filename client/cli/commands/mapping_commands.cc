// motiondb mapping: adds, lists, shows and deletes mappings. motiondb marker-set: shows a set.

#include <fmt/format.h>
#include <motiondb/v1/marker_set.pb.h>

#include <algorithm>

#include "client/cli/command.h"
#include "client/cli/motion_file.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {

namespace {

struct MappingOptions {
  std::string database;
  std::string file;
  std::string name;
};

struct MappingListOptions : MappingOptions {
  static constexpr bool kPrintsTable = true;
};

struct MarkerSetOptions {
  std::string set;
  std::string database;
};

absl::StatusOr<v1::MarkerSet> MarkerSetOf(const Client& client, const std::string& database) {
  v1::GetMarkerSetRequest request;
  if (!database.empty()) request.set_database(DatabaseName(database));
  auto response = client.GetMarkerSet(request);
  if (!response.ok()) return response.status();
  return std::move(*response->mutable_marker_set());
}

Table MappingsTable(const v1::MarkerSet& set) {
  Table table({{"MAPPING"}, {"POINTS", Align::kRight}, {"SIGNATURE"}});
  for (const v1::Mapping& mapping : set.mappings()) {
    constexpr int kShown = 4;
    std::string signature;
    for (int i = 0; i < std::min(kShown, mapping.signature_size()); ++i) {
      signature += (i > 0 ? " " : "") + mapping.signature(i);
    }
    if (mapping.signature_size() > kShown) signature += " ...";
    table.AddRow({mapping.name(), mapping.signature_size(), signature});
  }
  return table;
}

void DeclareAdd(CLI::App& command, MappingOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("FILE", options.file, "Marker-set file that contains only mappings")
      ->required();
}

absl::Status RunAdd(const MappingOptions& options, const GlobalOptions& global) {
  auto text = ReadTextFile(options.file);
  if (!text.ok()) return text.status();
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::AddMappingsRequest request;
  request.set_database(DatabaseName(options.database));
  request.set_mapping_file(*std::move(text));
  const auto response = client->AddMappings(request);
  if (!response.ok()) return response.status();
  if (global.json) {
    PrintJson(*response);
    return absl::OkStatus();
  }
  for (const v1::Mapping& mapping : response->mappings()) {
    PrintLine("added mapping {} for {}", mapping.name(),
              CountText(mapping.signature_size(), "joint or marker name"));
  }
  PrintLine(
      "files and streams that arrive from now on use it; for stored clips run: motiondb "
      "reprocess {}",
      ShortName(request.database()));
  return absl::OkStatus();
}

void DeclareList(CLI::App& command, MappingListOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
}

absl::Status RunList(const MappingListOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto set = MarkerSetOf(*client, options.database);
  if (!set.ok()) return set.status();
  if (global.json) {
    for (const v1::Mapping& mapping : set->mappings()) PrintJson(mapping);
  } else {
    PrintTable(MappingsTable(*set), global.csv, "no mappings");
  }
  return absl::OkStatus();
}

void DeclareNamed(CLI::App& command, MappingOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("NAME", options.name, "Name in `motiondb mapping list`")->required();
}

absl::Status RunShow(const MappingOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto set = MarkerSetOf(*client, options.database);
  if (!set.ok()) return set.status();
  const auto found = std::ranges::find_if(
      set->mappings(), [&](const auto& mapping) { return mapping.name() == options.name; });
  if (found == set->mappings().end()) {
    return absl::NotFoundError(fmt::format("marker set '{}' of {} has no mapping '{}'", set->name(),
                                           DatabaseName(options.database), options.name));
  }
  if (global.json) {
    PrintJson(*found);
  } else {
    // A file for `mapping add`.
    PrintText("motiondb-marker-set 1\n" + found->text());
  }
  return absl::OkStatus();
}

absl::Status RunDelete(const MappingOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::DeleteMappingRequest request;
  request.set_database(DatabaseName(options.database));
  request.set_mapping(options.name);
  const auto response = client->DeleteMapping(request);
  if (!response.ok()) return response.status();
  if (global.json) {
    PrintJson(*response);
  } else {
    PrintLine("deleted mapping {}; stored clips are unchanged until: motiondb reprocess {}",
              options.name, ShortName(request.database()));
  }
  return absl::OkStatus();
}

void DeclareShowSet(CLI::App& command, MarkerSetOptions& options) {
  command.add_option("SET", options.set, "Name of a built-in marker set")
      ->type_name("standard34")
      ->check(CLI::IsMember({"standard34"}));
  command
      .add_option("--database", options.database, "Show the marker set of this database instead")
      ->type_name("DB");
}

absl::Status RunShowSet(const MarkerSetOptions& options, const GlobalOptions& global) {
  if (options.set.empty() == options.database.empty()) {
    return UsageError("expected either standard34 or --database DB");
  }
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto set = MarkerSetOf(*client, options.database);
  if (!set.ok()) return set.status();
  if (global.json) {
    PrintJson(*set);
    return absl::OkStatus();
  }
  PrintText(set->text());
  for (const v1::Mapping& mapping : set->mappings()) PrintText('\n' + mapping.text());
  return absl::OkStatus();
}

}  // namespace

void AddMappingCommand(CommandLine line) {
  const CommandLine inner = AddCommandGroup(
      line, "mapping", "Add, list, show or delete the mappings of a database",
      "motiondb inspect walk.fbx --write-mapping rig.txt\nmotiondb mapping add walks rig.txt");
  AddCommand<MappingOptions>(inner, "add", "Add the mappings of a file; equal names are replaced",
                             "motiondb mapping add walks rig.txt", DeclareAdd, RunAdd);
  AddCommand<MappingListOptions>(inner, "list", "List the mappings of a database",
                                 "motiondb mapping list walks", DeclareList, RunList);
  AddCommand<MappingOptions>(inner, "show", "Print a mapping as a file for `mapping add`",
                             "motiondb mapping show walks rig --output rig.txt", DeclareNamed,
                             RunShow);
  AddCommand<MappingOptions>(inner, "delete", "Delete a mapping",
                             "motiondb mapping delete walks rig", DeclareNamed, RunDelete);
}

void AddMarkerSetCommand(CommandLine line) {
  const CommandLine inner = AddCommandGroup(line, "marker-set", "Show a marker set",
                                            "motiondb marker-set show standard34");
  AddCommand<MarkerSetOptions>(
      inner, "show", "Print a marker set as a marker-set file",
      "motiondb marker-set show standard34\nmotiondb marker-set show --database walks",
      DeclareShowSet, RunShowSet);
}

}  // namespace motiondb::client
