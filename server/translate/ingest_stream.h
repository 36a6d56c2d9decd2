// Converts messages to a clip to ingest: the whole clip of UploadClip, and the stream of
// IngestClip.
#pragma once

#include <cstddef>
#include <string>

#include "absl/status/statusor.h"
#include "server/engine/ingest.h"

namespace motiondb::v1 {
class IngestClipHeader;
class IngestClipRequest;
class UploadClipRequest;
}  // namespace motiondb::v1

namespace motiondb::server {

// Returns the request without the bytes of the files; the rules for it are CheckNewClip.
// INVALID_ARGUMENT with the field, as in "header.format". Does not read the database, `parent`.
absl::StatusOr<IngestRequest> ParseIngestHeader(const v1::IngestClipHeader& header);

// Returns the whole clip, by the rules of server/engine/ingest_rules.h. INVALID_ARGUMENT,
// RESOURCE_EXHAUSTED.
absl::StatusOr<IngestRequest> ParseUpload(const v1::UploadClipRequest& message,
                                          std::size_t max_file_bytes);

// Maximum size of a file block in one message.
inline constexpr std::size_t kMaxBlockBytes = std::size_t{1} << 20;

// Collects the messages of an ingest stream into a file to ingest, and checks each message.
class IngestStream {
 public:
  explicit IngestStream(std::size_t max_file_bytes) : max_file_bytes_(max_file_bytes) {}

  // Adds the next message. Returns INVALID_ARGUMENT if it is invalid or out of order;
  // RESOURCE_EXHAUSTED if the file is larger than the limit.
  absl::Status Take(v1::IngestClipRequest message);

  // Id of the database; empty before the header.
  const std::string& database() const { return database_; }
  // Whether the header asks to store nothing.
  bool validate_only() const { return request_.validate_only; }
  // Whether the file is one that motiondb-import reads; false before the header.
  bool needs_import() const { return !database_.empty() && NeedsImport(request_); }
  // Bytes received so far, of the file and its skeleton.
  std::size_t byte_count() const {
    return request_.clip.file_bytes.size() + request_.clip.skeleton_bytes.size();
  }

  // Returns the clip to ingest, after the end of the stream. Returns INVALID_ARGUMENT if something
  // is missing.
  absl::StatusOr<IngestRequest> Finish();

 private:
  absl::Status TakeHeader(const v1::IngestClipHeader& header);
  absl::Status TakeBlock(std::string_view field, std::string& block, std::string& bytes);

  const std::size_t max_file_bytes_;
  std::string database_;
  IngestRequest request_;
};

}  // namespace motiondb::server
