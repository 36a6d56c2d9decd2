#include <catch2/catch.hpp>
#include <cstring>
#include <string>
#include <vector>

#include "storage/blob/checksums.h"
#include "storage/blob/chunk_stream.h"
#include "tests/storage/require_ok.h"

namespace motiondb::tests::chunk_test {
namespace {

using storage::BlobKind;
using storage::kChunkHeaderBytes;
using storage::kChunkPayloadBytes;
using Bytes = std::vector<std::byte>;

std::span<const std::byte> BytesOf(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

// Returns the chunks of a blob that is written in parts of `part` bytes.
std::vector<Bytes> Cut(std::string_view blob, std::size_t part) {
  std::vector<Bytes> chunks;
  storage::ChunkSink sink(BlobKind::kStates,
                          [&](std::uint32_t position, std::span<const std::byte> chunk) {
                            REQUIRE(position == chunks.size());
                            chunks.emplace_back(chunk.begin(), chunk.end());
                            return absl::OkStatus();
                          });
  for (std::size_t begin = 0; begin < blob.size(); begin += part) {
    REQUIRE_OK(sink.Write(BytesOf(blob.substr(begin, part))));
  }
  REQUIRE_OK(sink.Finish());
  return chunks;
}

absl::StatusOr<std::string> Join(const std::vector<Bytes>& chunks) {
  std::size_t total = 0;
  for (const Bytes& chunk : chunks) total += chunk.size() - kChunkHeaderBytes;
  std::size_t next = 0;
  storage::ChunkSource source(BlobKind::kStates, total,
                              [&]() -> absl::StatusOr<std::span<const std::byte>> {
                                if (next == chunks.size()) return std::span<const std::byte>();
                                return chunks[next++];
                              });
  std::string blob(total, '\0');
  absl::Status read = source.Read(std::as_writable_bytes(std::span(blob)));
  if (read.ok()) read = source.Finish();
  if (!read.ok()) return read;
  return blob;
}

}  // namespace

TEST_CASE("Crc32: equals the CRC-32 of zlib, gzip and PNG", "[storage][blob]") {
  REQUIRE(storage::Crc32(BytesOf("123456789")) == 0xcbf43926);
  REQUIRE(storage::Crc32(BytesOf("6789"), storage::Crc32(BytesOf("12345"))) == 0xcbf43926);
  REQUIRE(storage::Crc32({}, 17) == 17);
}

TEST_CASE("Chunk: has the documented layout", "[storage][blob]") {
  Bytes chunk(kChunkHeaderBytes + 3);
  std::memcpy(chunk.data() + kChunkHeaderBytes, "abc", 3);
  storage::SealChunk(BlobKind::kModel, 258, /*last=*/true, chunk);
  const std::string expected{'m', 'd', 'c', 'k', 1, 0, 5, 0, 2, 1, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0};
  REQUIRE(std::memcmp(chunk.data(), expected.data(), expected.size()) == 0);
  std::uint32_t crc = 0;
  std::memcpy(&crc, chunk.data() + 20, sizeof(crc));
  REQUIRE(crc == storage::Crc32(BytesOf("abc"), storage::Crc32(BytesOf(expected))));
}

TEST_CASE("Chunk: any flipped bit and any truncation is detected", "[storage][blob]") {
  Bytes chunk(kChunkHeaderBytes + 40, std::byte{7});
  storage::SealChunk(BlobKind::kStates, 3, /*last=*/false, chunk);
  const auto opened = Require(storage::OpenChunk(BlobKind::kStates, 3, chunk));
  REQUIRE(opened.payload.size() == 40);
  REQUIRE_FALSE(opened.last);
  for (std::size_t bit = 0; bit < 8 * chunk.size(); ++bit) {
    Bytes changed = chunk;
    changed[bit / 8] ^= std::byte{1} << (bit % 8);
    REQUIRE_ERROR(storage::OpenChunk(BlobKind::kStates, 3, changed), absl::StatusCode::kDataLoss,
                  "states: chunk 3 is corrupt");
  }
  for (std::size_t size = 0; size < chunk.size(); ++size) {
    REQUIRE_ERROR(storage::OpenChunk(BlobKind::kStates, 3, std::span(chunk).first(size)),
                  absl::StatusCode::kDataLoss, "chunk 3");
  }
  REQUIRE_ERROR(storage::OpenChunk(BlobKind::kStates, 4, chunk), absl::StatusCode::kDataLoss,
                "belongs to another");
  REQUIRE_ERROR(storage::OpenChunk(BlobKind::kModel, 3, chunk), absl::StatusCode::kDataLoss,
                "belongs to another");
}

TEST_CASE("ChunkStream: a blob of any length can be written and read", "[storage][blob]") {
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, kChunkPayloadBytes - 1, kChunkPayloadBytes,
        kChunkPayloadBytes + 1, 3 * kChunkPayloadBytes}) {
    std::string blob(size, '\0');
    for (std::size_t i = 0; i < size; ++i) blob[i] = static_cast<char>(i * 31 >> 3);
    const auto chunks = Cut(blob, 10007);
    REQUIRE(chunks.size() ==
            std::max<std::size_t>(1, (size + kChunkPayloadBytes - 1) / kChunkPayloadBytes));
    REQUIRE(Require(Join(chunks)) == blob);
    REQUIRE(Cut(blob, size + 1) == chunks);
  }
}

TEST_CASE("ChunkStream: a missing, duplicated or misplaced chunk is detected", "[storage][blob]") {
  const auto chunks = Cut(std::string(3 * kChunkPayloadBytes, 'x'), 1 << 20);
  REQUIRE_ERROR(Join({chunks[0], chunks[1]}), absl::StatusCode::kDataLoss, "chunk 2 is missing");
  REQUIRE_ERROR(Join({chunks[0], chunks[2]}), absl::StatusCode::kDataLoss, "chunk 1");
  REQUIRE_ERROR(Join({chunks[1], chunks[0], chunks[2]}), absl::StatusCode::kDataLoss, "chunk 0");
  REQUIRE_ERROR(Join({chunks[0], chunks[1], chunks[2], chunks[2]}), absl::StatusCode::kDataLoss,
                "ends too early");
  REQUIRE_ERROR(Join({}), absl::StatusCode::kDataLoss, "chunk 0 is missing");
}

}  // namespace motiondb::tests::chunk_test
