#include "client/cli/ingest_batch.h"

#include <fmt/format.h>
#include <motiondb/call_error.h>
#include <motiondb/v1/clip.pb.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/numbers.h"
#include "client/call_failure.h"
#include "client/cli/database_text.h"
#include "client/cli/rebuild_wait.h"
#include "client/cli/resource_name.h"
#include "client/cli/server_text.h"
#include "client/cli/terminal/print.h"
#include "client/cli/terminal/terminal.h"
#include "text/display_text.h"

namespace motiondb::client {

namespace {

constexpr double kSecondsUntilEstimate = 3;

// A message with another text cannot be sent.
absl::Status CheckTexts(const ClipEntry& clip) {
  const auto check = [](const std::string& what, const std::string& text) {
    if (text::IsUtf8(text)) return absl::OkStatus();
    return absl::InvalidArgumentError(fmt::format("the {} is not UTF-8 text", what));
  };
  absl::Status checked = check("label", clip.label);
  checked.Update(check("subject", clip.subject));
  checked.Update(check("name", clip.path.filename().string()));
  checked.Update(check("title", clip.title));
  checked.Update(check("description", clip.description));
  for (const std::string& tag : clip.tags) checked.Update(check("tag", tag));
  for (const auto& [name, value] : clip.fields) {
    checked.Update(check("name of a field", name));
    checked.Update(check(fmt::format("field {}", name), value.text()));
  }
  return checked;
}

}  // namespace

std::string FileProgressText(std::size_t done, std::size_t count, const std::string& name,
                             double seconds) {
  std::string text = fmt::format("{} of {}  {}", done + 1, count, name);
  if (done == 0 || seconds < kSecondsUntilEstimate) return text;
  const double left = seconds / static_cast<double>(done) * static_cast<double>(count - done);
  return text + fmt::format("  about {} left", DurationText(std::llround(std::ceil(left))));
}

IngestBatch::IngestBatch(const Client& client, std::string database, IngestSettings settings)
    : client_(client), database_(std::move(database)), settings_(std::move(settings)) {}

absl::Status IngestBatch::Send(const std::vector<ClipEntry>& clips) {
  std::optional<ProgressBar> bar;
  if (settings_.output != IngestOutput::kNothing) bar.emplace();
  const auto begin = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < clips.size(); ++i) {
    const ClipEntry& clip = clips[i];
    if (bar) {
      const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
      bar->Show(static_cast<double>(i) / static_cast<double>(clips.size()),
                FileProgressText(i, clips.size(), clip.path.filename().string(), passed.count()));
    }
    const absl::Status sent = SendTakes(clip, [&](const v1::IngestClipResponse& response) {
      // Without lines between the files, the bar stays, so that it does not flicker.
      if (bar && settings_.output != IngestOutput::kSummary) bar->Clear();
      Accept(response);
    });
    if (sent.ok()) continue;
    failures_.push_back(FailureOf(clip.path, sent.message()));
    if (!absl::IsUnavailable(sent)) continue;
    const std::string stopped =
        fmt::format("stopped after {} of {}", i, CountText(clips.size(), "file"));
    return absl::UnavailableError(
        settings_.dry_run
            ? stopped
            : fmt::format("{}; {}; `motiondb list {}` shows whether the last file is stored",
                          stopped, StoredText(), ShortName(database_)));
  }
  return absl::OkStatus();
}

absl::Status IngestBatch::SendTakes(
    const ClipEntry& clip, const std::function<void(const v1::IngestClipResponse&)>& accept) const {
  const auto response = SendOne(clip, settings_.source.take);
  if (response.ok()) {
    accept(*response);
    return absl::OkStatus();
  }
  if (ErrorReason(response.status()) != "TAKE_REQUIRED") return response.status();
  const auto names =
      nlohmann::json::parse(ErrorMetadata(response.status(), "takes"), nullptr, false);
  int count = 0;
  if (!absl::SimpleAtoi(ErrorMetadata(response.status(), "take_count"), &count)) {
    return response.status();
  }
  // A take that cannot be stored does not stop the others.
  absl::Status first_error;
  for (int i = 0; i < count; ++i) {
    const bool has_name =
        names.is_array() && i < static_cast<int>(names.size()) && names[i].is_string();
    const std::string take = has_name ? names[i].get<std::string>() : std::to_string(i + 1);
    const auto stored = SendOne(clip, take);
    if (absl::IsUnavailable(stored.status())) return stored.status();
    if (stored.ok()) accept(*stored);
    if (!stored.ok() && first_error.ok()) {
      first_error =
          WithMessage(stored.status(),
                      fmt::format("take '{}': {}", take, std::string(stored.status().message())));
    }
  }
  return first_error;
}

absl::StatusOr<v1::IngestClipResponse> IngestBatch::SendOne(const ClipEntry& clip,
                                                            const std::string& take) const {
  const auto skeleton = SkeletonFor(clip.path, clip.skeleton);
  if (!skeleton.ok()) return skeleton.status();
  if (const absl::Status status = CheckTexts(clip); !status.ok()) return status;
  v1::IngestClipHeader header;
  header.set_parent(database_);
  header.set_label(clip.label);
  header.set_subject(clip.subject);
  header.set_title(clip.title);
  header.set_description(clip.description);
  for (const std::string& tag : clip.tags) header.add_tags(tag);
  for (const auto& [name, value] : clip.fields) (*header.mutable_fields())[name] = value;
  header.set_replace(settings_.replace);
  header.set_validate_only(settings_.dry_run);
  *header.mutable_conventions() = Conventions(settings_.source);
  header.mutable_conventions()->set_take(take);
  return client_.IngestFile(header, clip.path, *skeleton);
}

void IngestBatch::Accept(const v1::IngestClipResponse& response) {
  ++accepted_clips_;
  accepted_frames_ += response.clip().frame_count();
  // The last requested rebuild includes all clips, because it begins after they were stored.
  operation_ = response.operation().name();
  if (settings_.output == IngestOutput::kJson) PrintJson(response);
  if (settings_.output == IngestOutput::kEachClip) PrintText(IngestedClipText(response.clip()));
  // Flushes, so that a script knows the stored clips even if this process is killed.
  FlushOutput();
}

bool IngestBatch::PrintsSummary() const {
  return settings_.output == IngestOutput::kSummary || settings_.output == IngestOutput::kEachClip;
}

std::string IngestBatch::StoredText() const {
  return fmt::format("{} {} stored", CountText(accepted_clips_, "clip"),
                     accepted_clips_ == 1 ? "is" : "are");
}

std::string IngestBatch::AmountText() const {
  return fmt::format("{}, {}", CountText(accepted_clips_, "clip"),
                     CountText(accepted_frames_, "frame"));
}

absl::Status IngestBatch::Finish() {
  if (settings_.dry_run) {
    if (accepted_clips_ > 0 && PrintsSummary()) PrintLine("would store {}", AmountText());
    return absl::OkStatus();
  }
  if (operation_.empty()) return absl::OkStatus();
  if (settings_.waits_for_model) return AwaitModel();
  if (PrintsSummary()) {
    PrintLine("stored {}; the model is built by {} (motiondb operations wait {})", AmountText(),
              operation_, ShortName(operation_));
  }
  return absl::OkStatus();
}

absl::Status IngestBatch::AwaitModel() const {
  if (settings_.output == IngestOutput::kNothing) {
    const auto done = client_.WaitOperation(operation_);
    if (done.ok() && OperationStatus(*done).ok()) return absl::OkStatus();
    // Below, WaitForRebuild returns the same error with what is stored; nothing is left to wait
    // for.
  }
  const auto done = WaitForRebuild(client_, operation_, StoredText());
  if (!done.ok()) return done.status();
  if (!PrintsSummary()) return absl::OkStatus();
  const auto summary = ModelSummary(client_, *done);
  if (!summary.ok()) {
    return WithMessage(summary.status(),
                       fmt::format("{}; {} and in the model",
                                   std::string(summary.status().message()), StoredText()));
  }
  PrintLine("ingested {}; {}", AmountText(), *summary);
  return absl::OkStatus();
}

}  // namespace motiondb::client
