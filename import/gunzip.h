// Decompresses gzip files (RFC 1952).
#pragma once

#include <cstddef>
#include <string>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"

namespace motiondb::importer {

// Returns the content of a gzip file: that of all its members, one after the other. Decompression
// stops as soon as there are more than `max_bytes`.
//
// INVALID_ARGUMENT "FILE: byte N: ...", N in the compressed file: no gzip header, corrupt data, a
// wrong checksum or size, a truncated file, bytes after the last member that do not begin another
// one, or a content above the limit.
absl::StatusOr<std::string> Gunzip(core::SourceFile file, std::size_t max_bytes);

}  // namespace motiondb::importer
