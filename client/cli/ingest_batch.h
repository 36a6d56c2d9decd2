// Many files into one database, and the lists that name them.
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

// Lists of clips in a file: tab-separated, with a header line that names the columns. Pure
// functions.

// One clip to ingest; empty fields are not given.
struct ClipEntry {
  std::filesystem::path path;
  std::string label;
  std::string subject;
  std::filesystem::path skeleton;
};

// Reads a list: columns `path` and `label`, where present `subject` and `skeleton`, in any order,
// and any others, which are ignored. Blank lines and lines that begin with '#' count for nothing.
// Relative paths are relative to the list file. INVALID_ARGUMENT names the file, the line and what
// was expected.
absl::StatusOr<std::vector<ClipEntry>> ParseClipList(const std::filesystem::path& list_file,
                                                     std::string_view text);

// Many files into one database, one after the other: goes on past a bad file, stops when the server
// is gone, and waits for the model that knows them all.
class IngestBatch {
 public:
  // The client must outlive the batch. `json`: each answer is printed as JSON, and nothing else.
  IngestBatch(const Client& client, std::string database, SourceOptions source, bool json);

  // Sends every clip, printing each as it is stored. An error here is one that no further file
  // could escape; those of single files are kept.
  absl::Status Send(const std::vector<ClipEntry>& clips);

  // Waits for the new model, if anything was stored, and says what came of it.
  absl::Status AwaitModel();

  // The files that were not stored, each with its reason.
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
