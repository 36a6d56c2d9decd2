// Rules for a clip that a caller sends. Checked as its parts arrive, so that an invalid header ends
// the stream before the file is sent.
#pragma once

#include <cstddef>
#include <string_view>

#include "absl/status/status.h"
#include "server/engine/ingest.h"

namespace motiondb::server {

// Checks all but the bytes of the files, and sorts the tags. INVALID_ARGUMENT with the field of
// IngestClipHeader, as in "header.tags[3]".
absl::Status CheckNewClip(IngestRequest& request);

// Checks the id of a new clip: 1 to 127 of letters, digits, '-', '_', '.'. INVALID_ARGUMENT with
// the field.
absl::Status CheckClipId(std::string_view field, std::string_view id);

// Returns RESOURCE_EXHAUSTED if the files, with `more_bytes`, are larger than `max_file_bytes`.
absl::Status CheckFileSize(const IngestRequest& request, std::size_t more_bytes,
                           std::size_t max_file_bytes);

// Returns INVALID_ARGUMENT, with one of the fields, if a file has no bytes.
absl::Status CheckFiles(const IngestRequest& request, std::string_view file_field,
                        std::string_view skeleton_field);

}  // namespace motiondb::server
