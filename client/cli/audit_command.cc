// motiondb audit: what was changed or backed up, by whom, when and from where.
#include <motiondb/v1/access.pb.h>

#include <algorithm>

#include "client/cli/access_text.h"
#include "client/cli/command.h"
#include "client/cli/json_output.h"
#include "client/cli/print.h"

namespace motiondb::client {
namespace {

struct AuditOptions {
  int count = 100;
};

void Declare(CLI::App& command, AuditOptions& options) {
  command.add_option("--count", options.count, "How many, the newest first")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
}

absl::Status Run(const AuditOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::ListAuditEntriesResponse all;
  v1::ListAuditEntriesRequest request;
  do {
    request.set_page_size(options.count - all.entries_size());
    const auto page = client->ListAuditEntries(request);
    if (!page.ok()) return page.status();
    all.mutable_entries()->MergeFrom(page->entries());
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty() && all.entries_size() < options.count);
  if (global.json) {
    for (const v1::AuditEntry& entry : all.entries()) PrintJson(entry);
  } else {
    PrintText(AuditText(all));
  }
  return absl::OkStatus();
}

}  // namespace

void AddAuditCommand(CommandLine line) {
  AddCommand<AuditOptions>(line, "audit",
                           "List what was changed or backed up, by whom, when and from where",
                           Declare, Run);
}

}  // namespace motiondb::client
