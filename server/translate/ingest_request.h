// Converts the header of IngestClip and UploadClip to a clip to ingest, and checks its files.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

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

// Returns the request without the bytes of the files. INVALID_ARGUMENT with the field, as in
// "header.tags[3]".
absl::StatusOr<ParsedIngest> ParseIngestHeader(const v1::IngestClipHeader& header);

// Returns RESOURCE_EXHAUSTED if the files, with `more_bytes`, are larger than `max_file_bytes`.
absl::Status CheckFileSize(const IngestRequest& request, std::size_t more_bytes,
                           std::size_t max_file_bytes);

// Returns INVALID_ARGUMENT, with one of the fields, if a file has no bytes.
absl::Status CheckFiles(const IngestRequest& request, std::string_view file_field,
                        std::string_view skeleton_field);

// Returns the whole clip. INVALID_ARGUMENT, RESOURCE_EXHAUSTED.
absl::StatusOr<ParsedIngest> ParseUpload(const v1::UploadClipRequest& request,
                                         std::size_t max_file_bytes);

}  // namespace motiondb::server
