#include "storage/blob/chunk_stream.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <utility>

#include "core/motion/error.h"
#include "storage/blob/checksums.h"

namespace motiondb::storage {

ChunkSink::ChunkSink(BlobKind kind, PutChunk put_chunk)
    : kind_(kind), put_chunk_(std::move(put_chunk)), chunk_(kChunkHeaderBytes) {}

absl::Status ChunkSink::Write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const std::size_t room = kChunkHeaderBytes + kChunkPayloadBytes - chunk_.size();
    if (room == 0) {
      MOTIONDB_RETURN_IF_ERROR(ApplyFilled(/*last=*/false));
      continue;
    }
    const auto part = bytes.first(std::min(room, bytes.size()));
    chunk_.insert(chunk_.end(), part.begin(), part.end());
    bytes = bytes.subspan(part.size());
  }
  return absl::OkStatus();
}

absl::Status ChunkSink::Finish() { return ApplyFilled(/*last=*/true); }

absl::Status ChunkSink::ApplyFilled(bool last) {
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
    return core::DataLoss("{}: {} unexpected bytes at the end", Describe(kind_), remaining_);
  }
  while (!current_.last) MOTIONDB_RETURN_IF_ERROR(Advance());
  return absl::OkStatus();
}

absl::Status ChunkSource::Advance() {
  if (position_ > 0 && current_.last) {
    return core::DataLoss("{}: ends too early, with chunk {}", Describe(kind_), position_ - 1);
  }
  MOTIONDB_ASSIGN_OR_RETURN(const auto chunk, next_chunk_());
  if (chunk.empty()) {
    return core::DataLoss("{}: chunk {} is missing", Describe(kind_), position_);
  }
  MOTIONDB_ASSIGN_OR_RETURN(current_, OpenChunk(kind_, position_, chunk));
  ++position_;
  return absl::OkStatus();
}

namespace {

constexpr std::uint32_t kMagic = 0x6b63646d;  // "mdck"
constexpr std::uint16_t kChunkVersion = 1;
constexpr std::uint32_t kLastFlag = 1;

struct Header {
  std::uint32_t magic = kMagic;
  std::uint16_t version = kChunkVersion;
  std::uint16_t kind = 0;
  std::uint32_t position = 0;
  std::uint32_t flags = 0;
  std::uint32_t payload_bytes = 0;
  std::uint32_t crc = 0;  // of the other header fields and the payload
};
static_assert(sizeof(Header) == kChunkHeaderBytes);

std::uint32_t Crc(const Header& header, std::span<const std::byte> payload) {
  const auto before_crc = std::as_bytes(std::span(&header, 1)).first<offsetof(Header, crc)>();
  return Crc32(payload, Crc32(before_crc));
}

}  // namespace

const char* Describe(BlobKind kind) {
  switch (kind) {
    case BlobKind::kMotionFile:
      return "motion file";
    case BlobKind::kSkeletonFile:
      return "skeleton file";
    case BlobKind::kStates:
      return "states";
    case BlobKind::kSkeleton:
      return "joints";
    case BlobKind::kModel:
      return "parts";
  }
  return "unknown";
}

void SealChunk(BlobKind kind, std::uint32_t position, bool last, std::span<std::byte> chunk) {
  const auto payload = chunk.subspan(kChunkHeaderBytes);
  Header header;
  header.kind = static_cast<std::uint16_t>(kind);
  header.position = position;
  header.flags = last ? kLastFlag : 0;
  header.payload_bytes = static_cast<std::uint32_t>(payload.size());
  header.crc = Crc(header, payload);
  std::memcpy(chunk.data(), &header, sizeof(header));
}

absl::StatusOr<OpenedChunk> OpenChunk(BlobKind kind, std::uint32_t position,
                                      std::span<const std::byte> chunk) {
  const auto corrupt = [&](std::string_view what) {
    return core::DataLoss("{}: chunk {} is corrupt: {}", Describe(kind), position, what);
  };
  if (chunk.size() < kChunkHeaderBytes) return corrupt("it is shorter than its header");
  Header header;
  std::memcpy(&header, chunk.data(), sizeof(header));
  const auto payload = chunk.subspan(kChunkHeaderBytes);
  if (header.magic != kMagic) return corrupt("its magic number is wrong");
  if (header.payload_bytes != payload.size()) return corrupt("its length differs from its header");
  if (header.crc != Crc(header, payload)) return corrupt("its checksum does not match");
  if (header.version != kChunkVersion) return corrupt("its format has a newer version");
  if (header.kind != static_cast<std::uint16_t>(kind) || header.position != position) {
    return corrupt("it belongs to another blob or position");
  }
  return OpenedChunk{payload, (header.flags & kLastFlag) != 0};
}

}  // namespace motiondb::storage
