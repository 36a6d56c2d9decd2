// Rules for a clip that a caller sends, and the id and the hash that it gets from its file. The
// rules are checked as its parts arrive, so that an invalid header ends the stream before the file
// is sent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
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

// Returns the file name without folders. Both '/' and '\' separate folders.
std::string WithoutFolders(std::string_view path);

// Returns the clip id for a file name without folders: its stem, and '-' and the take if there is
// one. ASCII characters that ids do not allow, and invalid UTF-8, become '_'. Latin letters lose
// their accents, combining accents are dropped, and other characters become 'u' and their code
// point in hexadecimal: two names differ also if they are in another script. Leaves room for a
// number suffix. Returns "clip" if nothing is left.
std::string ClipIdFromFileName(std::string_view file_name, std::string_view take = {});

// Returns the 64-bit FNV-1a hash of the motion file's length, its bytes, the skeleton file's bytes
// and the name of the take. It detects a file that was ingested before.
inline std::uint64_t ContentHash(std::string_view file, std::string_view skeleton,
                                 std::string_view take = {}) {
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&](std::uint8_t byte) { hash = (hash ^ byte) * 0x100000001b3; };
  for (int shift = 0; shift < 64; shift += 8) {
    add(static_cast<std::uint8_t>(std::uint64_t{file.size()} >> shift));
  }
  for (const char c : file) add(static_cast<std::uint8_t>(c));
  for (const char c : skeleton) add(static_cast<std::uint8_t>(c));
  if (!take.empty()) add(0);  // so that the take does not continue the skeleton
  for (const char c : take) add(static_cast<std::uint8_t>(c));
  return hash;
}

}  // namespace motiondb::server
