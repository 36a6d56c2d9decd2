// Ingests many files into a database; reads lists of clips.
#pragma once

#include <motiondb/client.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/motion_file.h"

namespace motiondb::client {

// A clip to ingest; empty fields are not set.
struct ClipEntry {
  std::filesystem::path path;
  std::string label;
  std::string subject;
  std::filesystem::path skeleton;
};

// Parses a list: tab-separated, with a header line that names the columns. Columns `path` and
// `label`, optionally `subject` and `skeleton`, in any order; others are ignored. Blank lines and
// lines that begin with '#' are ignored. Paths are relative to the list file. INVALID_ARGUMENT
// names the file, the line and what was expected.
absl::StatusOr<std::vector<ClipEntry>> ParseClipList(const std::filesystem::path& list_file,
                                                     std::string_view text);

// Ingests files one after the other. Continues after a bad file, stops if the server is
// unavailable, and waits for the new model.
class IngestBatch {
 public:
  // The client must outlive the batch. `json`: prints only the responses, as JSON.
  IngestBatch(const Client& client, std::string database, SourceOptions source, bool json);

  // Sends all clips and prints each when it is stored. Returns only an error that concerns all
  // files; failures() has the errors of single files.
  absl::Status Send(const std::vector<ClipEntry>& clips);

  // Waits for the new model, if anything was stored, and prints a summary.
  absl::Status AwaitModel();

  // Files that were not stored, with the reason.
  const std::vector<std::string>& failures() const { return failures_; }

 private:
  absl::StatusOr<v1::IngestClipResponse> SendOne(const ClipEntry& clip) const;
  void Stored(const v1::IngestClipResponse& response);
  std::string StoredText() const;  // "2 clips are stored"

  const Client& client_;
  const std::string database_;
  const SourceOptions source_;
  const bool json_;
  int stored_clips_ = 0;
  int64_t stored_frames_ = 0;
  std::string operation_;
  std::vector<std::string> failures_;
};

}  // namespace motiondb::client
