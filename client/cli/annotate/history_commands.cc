// motiondb history DB [CLIP] and motiondb undo DB EDIT.
#include <fmt/format.h>
#include <motiondb/v1/edit.pb.h>
#include <motiondb/v1/operation.pb.h>

#include <algorithm>
#include <utility>

#include "client/cli/annotate/annotation_text.h"
#include "client/cli/annotate/batch_edit.h"
#include "client/cli/command.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {
namespace {

struct HistoryOptions {
  static constexpr bool kPrintsTable = true;
  std::string database;
  std::string clip;
  int top = 20;
};

void Declare(CLI::App& command, HistoryOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("CLIP", options.clip, "Only edits of this clip and its segments");
  command.add_option("--top", options.top, "Maximum number of edits")
      ->type_name("K")
      ->check(PositiveNumber())
      ->capture_default_str();
  command.footer("The server keeps the last 10,000 edits. --json prints all objects of an edit.");
}

absl::Status Run(const HistoryOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::ListEditsRequest request;
  request.set_parent(DatabaseName(options.database));
  if (!options.clip.empty()) request.set_clip(ClipName(options.database, options.clip));
  std::vector<v1::Edit> edits;
  do {
    request.set_page_size(std::min(options.top - static_cast<int>(edits.size()), 1000));
    auto page = client->ListEdits(request);
    if (!page.ok()) return page.status();
    for (v1::Edit& edit : *page->mutable_edits()) edits.push_back(std::move(edit));
    request.set_page_token(page->edits().empty() ? "" : page->next_page_token());
  } while (!request.page_token().empty() && std::ssize(edits) < options.top);
  PrintItems(edits, global, EditsTable, "no edits");
  return absl::OkStatus();
}

struct UndoOptions {
  std::string database;
  std::string edit;
  bool no_wait = false;
};

void Declare(CLI::App& command, UndoOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("EDIT", options.edit, "Edit, as in `motiondb history DB`")->required();
  command.add_flag("--no-wait", options.no_wait, "Do not wait until the model has the old labels");
  command.footer("Fails and changes nothing if a later edit changed the same object.");
}

absl::Status Run(const UndoOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::UndoEditRequest request;
  request.set_name(EditName(options.database, options.edit));
  const auto response = client->UndoEdit(request);
  if (!response.ok()) return response.status();
  if (!options.no_wait) {
    const absl::Status fitted = WaitForModel(*client, response->operation().name(),
                                             fmt::format("edit {} is undone", options.edit));
    if (!fitted.ok()) return fitted;
  }
  if (global.json) {
    PrintJson(*response);
    return absl::OkStatus();
  }
  PrintLine("undone by edit {}; revision {}", ShortName(response->edit().name()),
            response->revision());
  for (const v1::EditedObject& object : response->edit().objects()) {
    PrintLine("  {}", EditedObjectText(object));
  }
  return absl::OkStatus();
}

}  // namespace

void AddHistoryCommand(CommandLine line) {
  AddCommand<HistoryOptions>(
      line, "history", "List the edits of a database or a clip, newest first",
      "motiondb history walks\nmotiondb history walks 07_01 --top 5", Declare, Run);
}

void AddUndoCommand(CommandLine line) {
  AddCommand<UndoOptions>(line, "undo", "Restore what an edit changed", "motiondb undo walks 17",
                          Declare, Run);
}

}  // namespace motiondb::client
