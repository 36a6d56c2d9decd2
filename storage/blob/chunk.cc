#include "storage/blob/chunk.h"

#include <cstring>
#include <string_view>

#include "core/motion/error.h"
#include "storage/blob/crc32.h"

namespace motiondb::storage {
namespace {

constexpr std::uint32_t kMagic = 0x6b63646d;  // "mdck"
constexpr std::uint16_t kVersion = 1;
constexpr std::uint32_t kLastFlag = 1;

struct Header {
  std::uint32_t magic = kMagic;
  std::uint16_t version = kVersion;
  std::uint16_t kind = 0;
  std::uint32_t position = 0;
  std::uint32_t flags = 0;
  std::uint32_t payload_bytes = 0;
  std::uint32_t crc = 0;  // of the header before it and of the payload
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
  const auto damaged = [&](std::string_view what) {
    return core::DataLoss("{}: chunk {} is damaged: {}", Describe(kind), position, what);
  };
  if (chunk.size() < kChunkHeaderBytes) return damaged("it is shorter than its header");
  Header header;
  std::memcpy(&header, chunk.data(), sizeof(header));
  const auto payload = chunk.subspan(kChunkHeaderBytes);
  if (header.magic != kMagic) return damaged("it does not begin as a chunk does");
  if (header.payload_bytes != payload.size()) return damaged("its length is not the one it states");
  if (header.crc != Crc(header, payload)) return damaged("its checksum does not match");
  if (header.version != kVersion) return damaged("its format is of a newer version");
  if (header.kind != static_cast<std::uint16_t>(kind) || header.position != position) {
    return damaged("it belongs elsewhere");
  }
  return OpenedChunk{payload, (header.flags & kLastFlag) != 0};
}

}  // namespace motiondb::storage
