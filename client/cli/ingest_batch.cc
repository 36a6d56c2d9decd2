#include "client/cli/ingest_batch.h"

#include <fmt/format.h>
#include <motiondb/v1/clip.pb.h>

#include "client/cli/count_text.h"
#include "client/cli/database_text.h"
#include "client/cli/json_output.h"
#include "client/cli/print.h"
#include "client/cli/progress_bar.h"
#include "client/cli/rebuild.h"
#include "client/cli/resource_name.h"
#include "client/grpc_status.h"
#include "text/display_text.h"

namespace motiondb::client {
namespace {

// "PATH: what was wrong"; readers' messages name the file themselves, without its folder.
std::string Failure(const std::filesystem::path& path, const absl::Status& status) {
  const std::string message(status.message());
  for (const std::string& name : {path.string(), path.filename().string()}) {
    if (message.rfind(name + ":", 0) == 0) return path.string() + message.substr(name.size());
  }
  return fmt::format("{}: {}", path.string(), message);
}

}  // namespace

IngestBatch::IngestBatch(const Client& client, std::string database, SourceOptions source,
                         bool json)
    : client_(client), database_(std::move(database)), source_(std::move(source)), json_(json) {}

absl::Status IngestBatch::Send(const std::vector<ClipEntry>& clips) {
  ProgressBar bar;
  for (size_t i = 0; i < clips.size(); ++i) {
    const ClipEntry& clip = clips[i];
    bar.Show(static_cast<double>(i) / static_cast<double>(clips.size()),
             fmt::format("{} of {}  {}", i + 1, clips.size(), clip.path.filename().string()));
    const auto response = SendOne(clip);
    bar.Clear();
    if (response.ok()) {
      Stored(*response);
      continue;
    }
    failures_.push_back(Failure(clip.path, response.status()));
    if (absl::IsUnavailable(response.status())) {
      return absl::UnavailableError(
          fmt::format("stopped after {} of {}; {}; `motiondb list {}` shows whether the last file "
                      "is, too",
                      i, CountText(clips.size(), "file"), StoredText(), ShortName(database_)));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<v1::IngestClipResponse> IngestBatch::SendOne(const ClipEntry& clip) const {
  const auto skeleton = SkeletonFor(clip.path, clip.skeleton);
  if (!skeleton.ok()) return skeleton.status();
  const std::pair<const char*, std::string> texts[] = {
      {"label", clip.label}, {"subject", clip.subject}, {"name", clip.path.filename().string()}};
  for (const auto& [what, text] : texts) {
    if (text::IsUtf8(text)) continue;
    return absl::InvalidArgumentError(fmt::format("its {} is not UTF-8 text", what));
  }
  v1::IngestClipHeader header;
  header.set_parent(database_);
  header.set_label(clip.label);
  header.set_subject(clip.subject);
  *header.mutable_conventions() = Conventions(source_);
  return client_.IngestFile(header, clip.path, *skeleton);
}

void IngestBatch::Stored(const v1::IngestClipResponse& response) {
  ++stored_clips_;
  stored_frames_ += response.clip().frame_count();
  // The last rebuild asked for begins after all clips before it were stored, so it knows them all.
  operation_ = response.operation().name();
  if (json_) {
    PrintJson(response);
  } else {
    PrintText(IngestedClipText(response.clip()));
  }
  // At once, so that a script which is ended knows what is stored.
  std::fflush(stdout);
}

std::string IngestBatch::StoredText() const {
  return fmt::format("{} {} stored", CountText(stored_clips_, "clip"),
                     stored_clips_ == 1 ? "is" : "are");
}

absl::Status IngestBatch::AwaitModel() {
  if (operation_.empty()) return absl::OkStatus();
  const auto done = WaitForRebuild(client_, operation_, StoredText());
  if (!done.ok()) return done.status();
  if (json_) return absl::OkStatus();
  const auto summary = ModelSummary(client_, *done);
  if (!summary.ok()) {
    return WithMessage(summary.status(),
                       fmt::format("{}; {}, and the model knows them",
                                   std::string(summary.status().message()), StoredText()));
  }
  PrintLine("ingested {}, {}; {}", CountText(stored_clips_, "clip"),
            CountText(stored_frames_, "frame"), *summary);
  return absl::OkStatus();
}

}  // namespace motiondb::client
