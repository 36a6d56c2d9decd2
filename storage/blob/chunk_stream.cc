#include "storage/blob/chunk_stream.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/motion/error.h"

namespace motiondb::storage {

ChunkSink::ChunkSink(BlobKind kind, PutChunk put_chunk)
    : kind_(kind), put_chunk_(std::move(put_chunk)), chunk_(kChunkHeaderBytes) {}

absl::Status ChunkSink::Write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const std::size_t room = kChunkHeaderBytes + kChunkPayloadBytes - chunk_.size();
    if (room == 0) {
      MOTIONDB_RETURN_IF_ERROR(PutFilled(/*last=*/false));
      continue;
    }
    const auto part = bytes.first(std::min(room, bytes.size()));
    chunk_.insert(chunk_.end(), part.begin(), part.end());
    bytes = bytes.subspan(part.size());
  }
  return absl::OkStatus();
}

absl::Status ChunkSink::Finish() { return PutFilled(/*last=*/true); }

absl::Status ChunkSink::PutFilled(bool last) {
  SealChunk(kind_, position_, last, chunk_);
  MOTIONDB_RETURN_IF_ERROR(put_chunk_(position_, chunk_));
  ++position_;
  chunk_.resize(kChunkHeaderBytes);
  return absl::OkStatus();
}

ChunkSource::ChunkSource(BlobKind kind, std::uint64_t payload_bytes, NextChunk next_chunk)
    : kind_(kind), remaining_(payload_bytes), next_chunk_(std::move(next_chunk)) {}

absl::Status ChunkSource::Read(std::span<std::byte> out) {
  if (out.size() > remaining_) {
    return core::DataLoss("{}: expected {} more bytes, got {}", Describe(kind_), out.size(),
                          remaining_);
  }
  while (!out.empty()) {
    if (current_.payload.empty()) {
      MOTIONDB_RETURN_IF_ERROR(Advance());
      continue;
    }
    const auto part = current_.payload.first(std::min(out.size(), current_.payload.size()));
    std::memcpy(out.data(), part.data(), part.size());
    current_.payload = current_.payload.subspan(part.size());
    out = out.subspan(part.size());
    remaining_ -= part.size();
  }
  return absl::OkStatus();
}

absl::Status ChunkSource::Finish() {
  if (remaining_ > 0) {
    return core::DataLoss("{}: {} bytes are left over", Describe(kind_), remaining_);
  }
  while (!current_.last) MOTIONDB_RETURN_IF_ERROR(Advance());
  return absl::OkStatus();
}

absl::Status ChunkSource::Advance() {
  if (position_ > 0 && current_.last) {
    return core::DataLoss("{}: ends early, with chunk {}", Describe(kind_), position_ - 1);
  }
  MOTIONDB_ASSIGN_OR_RETURN(const auto chunk, next_chunk_());
  if (chunk.empty()) {
    return core::DataLoss("{}: chunk {} is missing", Describe(kind_), position_);
  }
  MOTIONDB_ASSIGN_OR_RETURN(current_, OpenChunk(kind_, position_, chunk));
  ++position_;
  return absl::OkStatus();
}

}  // namespace motiondb::storage
