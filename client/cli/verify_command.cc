// motiondb verify: reads all that is stored and says what is damaged.
#include <fmt/format.h>
#include <motiondb/v1/store.pb.h>

#include "client/cli/command.h"
#include "client/cli/count_text.h"
#include "client/cli/json_output.h"
#include "client/cli/print.h"
#include "client/cli/progress_bar.h"

namespace motiondb::client {
namespace {

struct VerifyOptions {};

void Declare(CLI::App&, VerifyOptions&) {}

// One finding a line, on standard output: it is the answer.
void Print(const v1::Damage& damage) {
  PrintLine("damaged: {}{}{}", damage.resource(), damage.resource().empty() ? "" : ": ",
            damage.description());
}

absl::Status Run(const VerifyOptions&, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  ProgressBar bar;
  const auto on_message = [&](const v1::VerifyStoreResponse& message) {
    if (message.has_progress()) {
      bar.Show(message.progress(), "verifying");
      return absl::OkStatus();
    }
    bar.Clear();
    if (global.json) {
      PrintJson(message);
    } else if (message.has_damage()) {
      Print(message.damage());
    }
    return absl::OkStatus();
  };
  const auto summary = client->VerifyStore(on_message);
  bar.Clear();
  if (!summary.ok()) return summary.status();
  if (!global.json) {
    PrintLine("verified {}, {}, {}, {}, {:.1f} MB",
              CountText(summary->database_count(), "database"),
              CountText(summary->clip_count(), "clip"), CountText(summary->model_count(), "model"),
              CountText(summary->skeleton_count(), "skeleton"),
              static_cast<double>(summary->byte_count()) / 1e6);
  }
  if (summary->damage_count() == 0) return absl::OkStatus();
  return absl::DataLossError(
      fmt::format("{} of damage", CountText(summary->damage_count(), "finding")));
}

}  // namespace

void AddVerifyCommand(CommandLine line) {
  AddCommand<VerifyOptions>(line, "verify",
                            "Check everything that is stored; fails if something is damaged",
                            Declare, Run);
}

}  // namespace motiondb::client
