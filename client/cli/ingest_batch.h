// Many files into one database, one after the other: goes on past a bad file, stops when the server
// is gone, and waits for the model that knows them all.
#pragma once

#include <motiondb/client.h>

#include <string>
#include <utility>
#include <vector>

#include "client/cli/clip_list.h"
#include "client/cli/motion_file.h"

namespace motiondb::client {

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
