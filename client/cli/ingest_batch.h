// Ingests many files into a database, with progress, a summary, and the errors of single files.
#pragma once

#include <motiondb/client.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/clip_files.h"
#include "client/cli/file_failures.h"
#include "client/cli/motion_file.h"

namespace motiondb::client {

// What goes to standard output.
enum class IngestOutput {
  kNothing,   // and no progress
  kSummary,   // a line at the end
  kEachClip,  // each clip with its report, and the summary
  kJson,      // only the responses
};

struct IngestSettings {
  SourceOptions source;
  bool replace = false;
  bool dry_run = false;         // stores nothing
  bool waits_for_model = true;  // not of a dry run
  IngestOutput output = IngestOutput::kSummary;
};

// Returns the activity of a progress bar, "12 of 344  07_01.amc  about 20 s left": `done` files of
// `count` took `seconds`, and `name` is next. The time left is known after 3 s.
std::string FileProgressText(std::size_t done, std::size_t count, const std::string& name,
                             double seconds);

// Ingests files one after the other. Continues after a bad file, stops if the server is
// unavailable, and waits for the new model.
class IngestBatch {
 public:
  // The client must outlive the batch.
  IngestBatch(const Client& client, std::string database, IngestSettings settings);

  // Sends all clips. Returns only an error that concerns all files; failures() has the errors of
  // single files.
  absl::Status Send(const std::vector<ClipEntry>& clips);

  // Waits for the new model, if anything was stored, and prints a summary.
  absl::Status Finish();

  // Files that were not accepted.
  const std::vector<FileFailure>& failures() const { return failures_; }

 private:
  // Sends one take of a file, or its only one if `take` is empty.
  absl::StatusOr<v1::IngestClipResponse> SendOne(const ClipEntry& clip,
                                                 const std::string& take) const;
  // Sends the chosen take or all takes, and calls `accept` for each stored one. Returns the first
  // error.
  absl::Status SendTakes(const ClipEntry& clip,
                         const std::function<void(const v1::IngestClipResponse&)>& accept) const;
  void Accept(const v1::IngestClipResponse& response);
  absl::Status AwaitModel() const;
  bool PrintsSummary() const;
  std::string StoredText() const;  // "2 clips are stored"
  std::string AmountText() const;  // "2 clips, 200 frames"

  const Client& client_;
  const std::string database_;
  const IngestSettings settings_;
  int accepted_clips_ = 0;
  std::int64_t accepted_frames_ = 0;
  std::string operation_;
  std::vector<FileFailure> failures_;
};

}  // namespace motiondb::client
