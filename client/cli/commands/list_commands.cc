// motiondb list [DB]: databases, or the clips of one, or counts of their values. motiondb search DB
// TEXT...: full-text search for clips.
#include <fmt/format.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>

#include <algorithm>
#include <utility>

#include "absl/strings/str_join.h"
#include "client/cli/annotate/annotation_text.h"
#include "client/cli/command.h"
#include "client/cli/database_text.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {

namespace {

struct ListOptions {
  static constexpr bool kPrintsTable = true;
  std::string database;
  std::string filter;
  std::string order_by;
  std::vector<std::string> facets;
};

void Declare(CLI::App& command, ListOptions& options) {
  command.add_option("DB", options.database, "Database whose clips are listed; else all databases");
  AddFilterOption(command, options.filter, "List only clips that pass this filter");
  CLI::Option* const order_by = command.add_option(
      "--order-by", options.order_by, "Fields to sort by, as in 'duration desc, name'; else name");
  order_by->type_name("F");
  command
      .add_option(
          "--facets", options.facets,
          "Instead of clips, print how many have each value of these fields: label, subject, "
          "tags, track, format, source, or fields.NAME")
      ->type_name("FIELD,...")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->excludes(order_by);
}

absl::Status ListDatabases(const Client& client, const GlobalOptions& global) {
  const auto databases = client.AllDatabases();
  if (!databases.ok()) return databases.status();
  PrintItems(*databases, global, DatabasesTable,
             "no databases; create one with `motiondb create DB`");
  return absl::OkStatus();
}

absl::Status ListFacets(const Client& client, const ListOptions& options,
                        v1::ListClipsRequest request, const GlobalOptions& global) {
  request.set_page_size(1);
  for (const std::string& field : options.facets) request.add_facets(field);
  const auto response = client.ListClips(request);
  if (!response.ok()) return response.status();
  const std::vector<v1::Facet> facets(response->facets().begin(), response->facets().end());
  PrintItems(facets, global, FacetsTable, "no values");
  return absl::OkStatus();
}

absl::Status Run(const ListOptions& options, const GlobalOptions& global) {
  const bool selects = !options.filter.empty() || !options.order_by.empty();
  if (options.database.empty() && (selects || !options.facets.empty())) {
    return UsageError("--filter, --order-by and --facets need DB");
  }
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  if (options.database.empty()) return ListDatabases(*client, global);
  v1::ListClipsRequest request;
  request.set_parent(DatabaseName(options.database));
  request.set_filter(options.filter);
  if (!options.facets.empty()) return ListFacets(*client, options, request, global);
  request.set_page_size(1000);
  request.set_order_by(options.order_by);
  const auto clips = client->AllClips(request);
  if (!clips.ok()) return clips.status();
  PrintItems(*clips, global, ClipsTable,
             options.filter.empty() ? "no clips; add some with `motiondb ingest DB FILE...`"
                                    : "no clip passes the filter");
  if (!global.json && !global.csv) PrintText(UnderivedText(*clips));
  return absl::OkStatus();
}

}  // namespace

void AddListCommand(CommandLine line) {
  AddCommand<ListOptions>(line, "list", "List all databases, or the clips of a database",
                          "motiondb list\n"
                          "motiondb list walks --csv --output clips.csv\n"
                          "motiondb list walks --filter 'label = \"walk\" AND subject != \"07\"'\n"
                          "motiondb list walks --order-by 'duration desc'\n"
                          "motiondb list walks --facets label,tags",
                          Declare, Run);
}

// motiondb search

namespace {

struct SearchOptions {
  static constexpr bool kPrintsTable = true;
  std::string database;
  std::vector<std::string> words;
  std::string filter;
  int top = 20;
};

void Declare(CLI::App& command, SearchOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command
      .add_option("TEXT", options.words,
                  "Words, all of which must occur; walk* is a beginning, '\"slow walk\"' a phrase")
      ->required();
  AddFilterOption(command, options.filter, "Find only clips that pass this filter");
  command.add_option("--top", options.top, "Maximum number of clips")
      ->type_name("K")
      ->check(PositiveNumber())
      ->capture_default_str();
  command.footer(
      "Searches titles, descriptions, tags, labels, subjects and file names; the best match is "
      "first.");
}

absl::Status Run(const SearchOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::SearchClipsRequest request;
  request.set_parent(DatabaseName(options.database));
  request.set_query(absl::StrJoin(options.words, " "));
  request.set_filter(options.filter);
  std::vector<v1::ClipMatch> matches;
  int total = 0;
  do {
    request.set_page_size(std::min(options.top - static_cast<int>(matches.size()), 1000));
    auto page = client->SearchClips(request);
    if (!page.ok()) return page.status();
    for (v1::ClipMatch& match : *page->mutable_matches()) matches.push_back(std::move(match));
    total = page->total_count();
    request.set_page_token(page->matches().empty() ? "" : page->next_page_token());
  } while (!request.page_token().empty() && std::ssize(matches) < options.top);
  PrintItems(matches, global, MatchesTable, "no clip matches");
  if (!global.json && !global.csv && total > std::ssize(matches)) {
    PrintLine("{} of {}; --top K prints more", matches.size(), CountText(total, "clip"));
  }
  return absl::OkStatus();
}

}  // namespace

void AddSearchCommand(CommandLine line) {
  AddCommand<SearchOptions>(line, "search", "Find clips by words in their texts",
                            "motiondb search walks slow walk\n"
                            "motiondb search walks 'turn*' --filter 'subject = \"07\"' --top 5",
                            Declare, Run);
}

}  // namespace motiondb::client
