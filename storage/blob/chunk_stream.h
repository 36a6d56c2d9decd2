// Chunks: what a blob is cut into, each with a header that tells what it is and a checksum that
// tells damage. docs/storage_format.md gives the layout byte by byte. Functions keep no state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/blob/byte_stream.h"

namespace motiondb::storage {

// What a blob holds. Stored: values do not change.
enum class BlobKind : std::uint16_t {
  kMotionFile = 1,    // the bytes of a motion file
  kSkeletonFile = 2,  // the bytes of the skeleton file that came with it
  kStates = 3,        // clip_codec.h
  kSkeleton = 4,      // clip_codec.h
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

// A blob as a stream over its chunks: at most one chunk is in memory. Not thread-safe.
class ChunkSink final : public ByteSink {
 public:
  // Keeps one sealed chunk, which is valid during the call.
  using PutChunk =
      std::function<absl::Status(std::uint32_t position, std::span<const std::byte> chunk)>;

  ChunkSink(BlobKind kind, PutChunk put_chunk);

  absl::Status Write(std::span<const std::byte> bytes) override;
  // Puts the last chunk, which an empty blob has too.
  absl::Status Finish();

 private:
  absl::Status PutFilled(bool last);

  BlobKind kind_;
  PutChunk put_chunk_;
  std::uint32_t position_ = 0;
  std::vector<std::byte> chunk_;  // the header's place, then what was written of the payload
};

class ChunkSource final : public ByteSource {
 public:
  // The next chunk, valid until the next call; an empty span after the last.
  using NextChunk = std::function<absl::StatusOr<std::span<const std::byte>>()>;

  // `payload_bytes` is what the chunks hold together without their headers.
  ChunkSource(BlobKind kind, std::uint64_t payload_bytes, NextChunk next_chunk);

  absl::Status Read(std::span<std::byte> out) override;
  absl::Status Finish() override;
  std::uint64_t remaining() const override { return remaining_; }

 private:
  absl::Status Advance();

  BlobKind kind_;
  std::uint64_t remaining_;
  NextChunk next_chunk_;
  std::uint32_t position_ = 0;  // of the next chunk
  OpenedChunk current_;         // its payload is what is not yet read
};

}  // namespace motiondb::storage
