// A blob as a stream over its chunks: at most one chunk is in memory. Not thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/blob/byte_stream.h"
#include "storage/blob/chunk.h"

namespace motiondb::storage {

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
