// Chunks: what a blob is cut into, each with a header that tells what it is and a checksum that
// tells damage. storage/README.md gives the layout byte by byte. Functions keep no state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "absl/status/statusor.h"

namespace motiondb::storage {

// What a blob holds. Stored: values do not change.
enum class BlobKind : std::uint16_t {
  kMotionFile = 1,    // the bytes of a motion file
  kSkeletonFile = 2,  // the bytes of the skeleton file that came with it
  kStates = 3,        // states_codec.h
  kSkeleton = 4,      // skeleton_codec.h
  kModel = 5,         // model_codec.h
};

// As messages call it: "states", "motion file".
const char* Describe(BlobKind kind);

inline constexpr std::size_t kChunkHeaderBytes = 24;
// Large enough that a row's cost does not count, small enough that damage and buffers stay small.
inline constexpr std::size_t kChunkPayloadBytes = 256 * 1024;

// Writes the header of a chunk: the first kChunkHeaderBytes of `chunk`, whose rest is the payload.
void SealChunk(BlobKind kind, std::uint32_t position, bool last, std::span<std::byte> chunk);

struct OpenedChunk {
  std::span<const std::byte> payload;  // a part of the chunk's own bytes
  bool last = false;
};

// DATA_LOSS, naming kind and position, unless it is the whole and undamaged chunk of that place.
absl::StatusOr<OpenedChunk> OpenChunk(BlobKind kind, std::uint32_t position,
                                      std::span<const std::byte> chunk);

}  // namespace motiondb::storage
