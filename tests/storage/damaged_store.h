// SQL that damages a store behind its back.
#pragma once

#include <string>

namespace motiondb::tests {

// Changes a byte of a chunk. `row` tells which chunk of `table`.
inline std::string ChangeByte(const std::string& table, int place, const std::string& row) {
  const std::string at = std::to_string(place);
  return "UPDATE " + table + " SET chunk = CAST(substr(chunk, 1, " + at +
         ") || x'A5' || substr(chunk, " + at + " + 2) AS BLOB) WHERE " + row;
}

// The rows of clip_chunk that are of one kind and clip.
inline std::string ChunksOf(const std::string& clip, int kind) {
  return "kind = " + std::to_string(kind) +
         " AND clip_key = (SELECT clip_key FROM clip WHERE id = '" + clip + "')";
}

}  // namespace motiondb::tests
