// motiondb search DB TEXT...: full-text search for clips.
#include <motiondb/v1/clip.pb.h>

#include <algorithm>
#include <utility>

#include "absl/strings/str_join.h"
#include "client/cli/annotate/annotation_text.h"
#include "client/cli/command.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {
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
