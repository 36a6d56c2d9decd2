// Collects the messages of an ingest stream into a file to ingest, and checks each message.
#pragma once

#include <cstddef>
#include <string>

#include "absl/status/statusor.h"
#include "server/engine/ingest.h"

namespace motiondb::v1 {
class IngestClipHeader;
class IngestClipRequest;
}  // namespace motiondb::v1

namespace motiondb::server {

// Maximum size of a file block in one message.
inline constexpr std::size_t kMaxBlockBytes = std::size_t{1} << 20;

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
