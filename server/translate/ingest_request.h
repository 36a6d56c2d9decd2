// Converts the header of IngestClip and UploadClip to a clip to ingest.
#pragma once

#include <cstddef>

#include "absl/status/statusor.h"
#include "server/engine/ingest.h"

namespace motiondb::v1 {
class IngestClipHeader;
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

}  // namespace motiondb::server
