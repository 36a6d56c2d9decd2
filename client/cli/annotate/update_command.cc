// motiondb update DB [CLIP]: changes label, subject, title, description, tags and fields of clips.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "client/call_failure.h"
#include "client/cli/annotate/batch_edit.h"
#include "client/cli/annotate/clip_edit.h"
#include "client/cli/command.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {
namespace {

// Attempts if another writer changes a clip between reading and writing its tags.
constexpr int kMaxAttempts = 5;

struct UpdateOptions {
  std::string database;
  std::string clip;
  std::string filter;
  ClipEdit edit;
  std::vector<std::string> fields;
  std::string etag;
  bool dry_run = false;
  bool no_wait = false;
};

void DeclareTexts(CLI::App& command, ClipEdit& edit) {
  command.add_option("--label", edit.label, "Label of the whole clip")->type_name("L");
  command.add_option("--subject", edit.subject, "Person or body that was recorded")->type_name("S");
  command.add_option("--title", edit.title, "Title, one line")->type_name("T");
  command.add_option("--description", edit.description, "Description")->type_name("TEXT");
}

void Declare(CLI::App& command, UpdateOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  CLI::Option* const clip = command.add_option("CLIP", options.clip, "Clip to change");
  CLI::Option* const filter = AddFilterOption(
      command, options.filter, "Change all clips that pass this filter, instead of CLIP");
  filter->excludes(clip);
  DeclareTexts(command, options.edit);
  AddRepeatedOption(command, "--tag", options.edit.tags, "TAG", "Tag to add; may be repeated");
  AddRepeatedOption(command, "--remove-tag", options.edit.removed_tags, "TAG",
                    "Tag to remove; may be repeated");
  AddFieldOption(command, options.fields, "Field to set, NAME=VALUE; may be repeated");
  AddRepeatedOption(command, "--remove-field", options.edit.removed_fields, "NAME",
                    "Field to remove; may be repeated");
  command
      .add_option("--etag", options.etag,
                  "Change nothing if the clip does not have this etag, from `motiondb list --json`")
      ->type_name("E")
      ->excludes(filter);
  command
      .add_flag("--dry-run", options.dry_run, "Print how many clips would change; change nothing")
      ->needs(filter);
  command.add_flag("--no-wait", options.no_wait, "Do not wait until the model has the new labels");
  command.footer(
      "The value of a field is true or false, a number, a time as 2026-01-31T10:00:00Z, or else "
      "text. A type before = forces it: --field run:text=07; types: text, number, flag, time. "
      "--filter changes 1,000 clips in a transaction.");
}

// Checks what the parser cannot, and adds the fields to the edit.
absl::StatusOr<ClipEdit> EditOf(const UpdateOptions& options) {
  if (options.clip.empty() == options.filter.empty()) {
    return UsageError("expected either CLIP or --filter");
  }
  ClipEdit edit = options.edit;
  for (const std::string& text : options.fields) {
    auto field = ParseFieldOption(text);
    if (!field.ok()) return UsageError(std::string(field.status().message()));
    edit.fields.insert_or_assign(field->first, std::move(field->second));
  }
  if (edit.empty()) return UsageError("nothing to change; expected --label, --tag or others");
  return edit;
}

absl::StatusOr<v1::Clip> ReadClip(const Client& client, const std::string& name) {
  v1::GetClipRequest request;
  request.set_name(name);
  auto response = client.GetClip(request);
  if (!response.ok()) return response.status();
  return std::move(*response->mutable_clip());
}

// Sends the change. With a given etag there is one attempt.
absl::StatusOr<v1::UpdateClipResponse> UpdateOne(const Client& client, const std::string& name,
                                                 const ClipEdit& edit, const std::string& etag) {
  for (int attempt = 1;; ++attempt) {
    v1::Clip stored;
    stored.set_name(name);
    if (edit.ChangesTags()) {
      auto read = ReadClip(client, name);
      if (!read.ok()) return read.status();
      stored = *std::move(read);
    }
    v1::UpdateClipRequest request = UpdateRequest(edit, stored);
    if (!etag.empty()) request.mutable_clip()->set_etag(etag);
    auto response = client.UpdateClip(request);
    const bool is_outdated = absl::IsAborted(response.status()) && etag.empty();
    if (!is_outdated || attempt == kMaxAttempts) return response;
  }
}

absl::Status RunOne(const Client& client, const UpdateOptions& options, const ClipEdit& edit,
                    bool json) {
  const std::string name = ClipName(options.database, options.clip);
  const auto response = UpdateOne(client, name, edit, options.etag);
  if (!response.ok()) return response.status();
  if (!options.no_wait) {
    const absl::Status fitted =
        WaitForModel(client, response->operation().name(), "the change is stored");
    if (!fitted.ok()) return fitted;
  }
  if (json) {
    PrintJson(*response);
  } else {
    PrintLine("updated clip {}; revision {}", ShortName(name), response->revision());
  }
  return absl::OkStatus();
}

// Sends the change for one transaction of clips. After another writer's change of one of them,
// reads them again.
absl::Status UpdateBatch(const Client& client, const std::string& database, const ClipEdit& edit,
                         std::vector<v1::Clip> clips, SentChanges& sent) {
  for (int attempt = 1;; ++attempt) {
    std::vector<v1::Change> changes;
    for (const v1::Clip& clip : clips) {
      *changes.emplace_back().mutable_update_clip() = UpdateRequest(edit, clip);
    }
    auto response = SendBatch(client, database, changes,
                              [&](std::size_t i) { return ShortName(clips[i].name()); });
    if (response.ok()) {
      sent.stored += changes.size();
      sent.responses.push_back(*std::move(response));
      return absl::OkStatus();
    }
    if (!absl::IsAborted(response.status()) || attempt == kMaxAttempts) return response.status();
    for (v1::Clip& clip : clips) {
      auto read = ReadClip(client, clip.name());
      if (!read.ok()) return read.status();
      clip = *std::move(read);
    }
  }
}

absl::Status RunFiltered(const Client& client, const UpdateOptions& options, const ClipEdit& edit,
                         bool json) {
  v1::ListClipsRequest request;
  request.set_parent(DatabaseName(options.database));
  request.set_page_size(options.dry_run ? 1 : 1000);
  request.set_filter(options.filter);
  if (options.dry_run) {
    const auto page = client.ListClips(request);
    if (!page.ok()) return page.status();
    if (json) {
      PrintText(fmt::format("{{\"clip_count\":{}}}\n", page->total_count()));
    } else {
      PrintLine("would update {}", CountText(page->total_count(), "clip"));
    }
    return absl::OkStatus();
  }
  const auto clips = client.AllClips(request);
  if (!clips.ok()) return clips.status();
  SentChanges sent;
  for (std::size_t begin = 0; begin < clips->size(); begin += kMaxBatchChanges) {
    const std::size_t end = std::min(begin + kMaxBatchChanges, clips->size());
    const absl::Status status = UpdateBatch(client, request.parent(), edit,
                                            {clips->begin() + static_cast<std::ptrdiff_t>(begin),
                                             clips->begin() + static_cast<std::ptrdiff_t>(end)},
                                            sent);
    if (status.ok()) continue;
    return WithMessage(status, fmt::format("{}; {} of {} updated", std::string(status.message()),
                                           sent.stored, CountText(std::ssize(*clips), "clip")));
  }
  const std::string count = CountText(static_cast<std::int64_t>(sent.stored), "clip");
  if (!options.no_wait) {
    const absl::Status fitted = WaitForModel(client, sent.operation(), count + " updated");
    if (!fitted.ok()) return fitted;
  }
  if (json) {
    for (const auto& response : sent.responses) PrintJson(response);
  } else if (sent.stored == 0) {
    PrintLine("updated no clips: none passes the filter");
  } else {
    PrintLine("updated {}; revision {}", count, sent.revision());
  }
  return absl::OkStatus();
}

absl::Status Run(const UpdateOptions& options, const GlobalOptions& global) {
  const auto edit = EditOf(options);
  if (!edit.ok()) return edit.status();
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  return options.filter.empty() ? RunOne(*client, options, *edit, global.json)
                                : RunFiltered(*client, options, *edit, global.json);
}

}  // namespace

void AddUpdateCommand(CommandLine line) {
  AddCommand<UpdateOptions>(
      line, "update", "Change label, subject, title, description, tags and fields of clips",
      "motiondb update walks 07_01 --label jog --tag outdoor\n"
      "motiondb update walks 07_01 --field weight_kg=72.5 --field run:text=07\n"
      "motiondb update walks --filter 'subject = \"07\"' --tag checked --dry-run",
      Declare, Run);
}

}  // namespace motiondb::client
