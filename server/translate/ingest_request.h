// Converts the header of IngestClip and UploadClip to a clip to ingest.
#pragma once

#include <cstddef>
#include <string>

#include "absl/status/statusor.h"
#include "server/engine/ingest.h"

namespace motiondb::v1 {
class IngestClipHeader;
class UploadClipRequest;
}  // namespace motiondb::v1

namespace motiondb::server {

struct ParsedIngest {
  std::string database;
  IngestRequest request;
};

// Returns the request without the bytes of the files; the rules for it are CheckNewClip.
// INVALID_ARGUMENT with the field, as in "header.format".
absl::StatusOr<ParsedIngest> ParseIngestHeader(const v1::IngestClipHeader& header);

// Returns the whole clip, by the rules of server/engine/ingest_rules.h. INVALID_ARGUMENT,
// RESOURCE_EXHAUSTED.
absl::StatusOr<ParsedIngest> ParseUpload(const v1::UploadClipRequest& request,
                                         std::size_t max_file_bytes);

}  // namespace motiondb::server
