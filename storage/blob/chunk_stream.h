// Chunks: a blob is split into chunks, each with a header and a checksum. docs/storage_format.md
// describes the layout.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/blob/byte_stream.h"

namespace motiondb::storage {

// Content of a blob. Stored: never change a value.
enum class BlobKind : std::uint16_t {
  kMotionFile = 1,    // the bytes of a motion file
  kSkeletonFile = 2,  // the bytes of the skeleton file that came with it
  kStates = 3,        // clip_codec.h
  kSkeleton = 4,      // clip_codec.h
  kModel = 5,         // model_codec.h
};

// Returns the name for messages: "states", "motion file".
const char* Describe(BlobKind kind);

inline constexpr std::size_t kChunkHeaderBytes = 24;
// Large enough to make the cost of a row negligible; small enough for small buffers and little loss
// by corruption.
inline constexpr std::size_t kChunkPayloadBytes = 256 * 1024;

// Writes the header of a chunk into its first kChunkHeaderBytes; the rest of `chunk` is the
// payload.
void SealChunk(BlobKind kind, std::uint32_t position, bool last, std::span<std::byte> chunk);

struct OpenedChunk {
  std::span<const std::byte> payload;  // refers to the bytes of the chunk
  bool last = false;
};

// Checks the header and the checksum of a chunk. DATA_LOSS, naming kind and position, if it is
// corrupt or belongs to another kind or position.
absl::StatusOr<OpenedChunk> OpenChunk(BlobKind kind, std::uint32_t position,
                                      std::span<const std::byte> chunk);

// Writes a blob as chunks; at most one chunk is in memory.
class ChunkSink final : public ByteSink {
 public:
  // Stores one sealed chunk, which is valid during the call.
  using PutChunk =
      std::function<absl::Status(std::uint32_t position, std::span<const std::byte> chunk)>;

  ChunkSink(BlobKind kind, PutChunk put_chunk);

  absl::Status Write(std::span<const std::byte> bytes) override;
  // Writes the last chunk. An empty blob has one empty chunk.
  absl::Status Finish();

 private:
  absl::Status ApplyFilled(bool last);

  BlobKind kind_;
  PutChunk put_chunk_;
  std::uint32_t position_ = 0;
  std::vector<std::byte> chunk_;  // space for the header, then the payload so far
};

// Reads a blob from its chunks; at most one chunk is in memory.
class ChunkSource final : public ByteSource {
 public:
  // Returns the next chunk, valid until the next call; an empty span after the last.
  using NextChunk = std::function<absl::StatusOr<std::span<const std::byte>>()>;

  // `payload_bytes`: the size of all chunks without their headers.
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
  OpenedChunk current_;         // its payload is the unread rest
};

}  // namespace motiondb::storage
