// The messages of an ingest stream -> a file to ingest, checked as they come. Used by one thread at
// a time.
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

// Of a file that is sent, in one message.
inline constexpr std::size_t kMostBlockBytes = std::size_t{1} << 20;

class IngestStream {
 public:
  explicit IngestStream(std::size_t max_file_bytes) : max_file_bytes_(max_file_bytes) {}

  // Takes the next message, of which a block is appended. INVALID_ARGUMENT if it is out of turn or
  // wrong; RESOURCE_EXHAUSTED if the file grows beyond the limit.
  absl::Status Take(v1::IngestClipRequest message);

  // Id of the database; empty until the header has come.
  const std::string& database() const { return database_; }
  // Of the file and its skeleton, so far.
  std::size_t byte_count() const { return file_.file_bytes.size() + file_.skeleton_bytes.size(); }

  // The file, when the stream has ended. INVALID_ARGUMENT if something is missing.
  absl::StatusOr<IngestFile> Finish();

 private:
  absl::Status TakeHeader(const v1::IngestClipHeader& header);
  absl::Status TakeBlock(std::string_view field, std::string& block, std::string& bytes);

  const std::size_t max_file_bytes_;
  std::string database_;
  IngestFile file_;
};

}  // namespace motiondb::server
