// Decompresses gzip files (RFC 1952).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"

namespace motiondb::core {

// Of a URDF file, and of every skeleton file (ASF, URDF) after decompression.
inline constexpr std::size_t kMaxSkeletonBytes = std::size_t{4} << 20;

// Returns the content of a gzip file: that of all its members, one after the other. Decompression
// stops as soon as there are more than `max_bytes`.
//
// INVALID_ARGUMENT "FILE: byte N: ...", N in the compressed file: no gzip header, corrupt data, a
// wrong checksum or size, a truncated file, bytes after the last member that do not begin another
// one, or a content above the limit.
absl::StatusOr<std::string> Gunzip(SourceFile file, std::size_t max_bytes);

// Returns the file, or if it is a gzip file, one with its name and its content, which `storage`
// holds. Errors of Gunzip.
absl::StatusOr<SourceFile> PlainFile(SourceFile file, std::size_t max_bytes, std::string& storage);

// Returns the size of the file or of its content up to the first error of PlainFile, whichever is
// larger.
std::size_t PlainBytes(std::string_view bytes, std::size_t max_bytes);

}  // namespace motiondb::core
