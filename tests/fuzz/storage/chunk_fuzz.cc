// Chunks of a blob from a corrupt store. The input is a sequence of chunks, each after its length
// (u32). If the first byte is odd, every checksum is recomputed, so that the code behind it is
// reached.
#include <cstring>
#include <vector>

#include "storage/blob/chunk_stream.h"
#include "tests/fuzz/support/memory_watch.h"
#include "tests/fuzz/support/properties.h"

using namespace motiondb;

namespace {

std::vector<std::vector<std::byte>> ChunksOf(std::span<const std::byte> bytes, bool seal) {
  std::vector<std::vector<std::byte>> chunks;
  while (bytes.size() >= sizeof(std::uint32_t)) {
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data(), sizeof(length));
    bytes = bytes.subspan(sizeof(length));
    const auto taken = bytes.first(std::min<std::size_t>(length, bytes.size()));
    bytes = bytes.subspan(taken.size());
    chunks.emplace_back(taken.begin(), taken.end());
    if (seal && taken.size() >= storage::kChunkHeaderBytes) {
      storage::SealChunk(storage::BlobKind::kStates, static_cast<std::uint32_t>(chunks.size() - 1),
                         bytes.empty(), chunks.back());
    }
  }
  return chunks;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const bool seal = (data[0] & 1) != 0;
  const auto chunks = ChunksOf(std::as_bytes(std::span(data + 2, size - 2)), seal);
  std::size_t payload_bytes = data[1];  // roughly the size in the store's table
  for (const auto& chunk : chunks) payload_bytes += chunk.size();
  payload_bytes -= std::min(payload_bytes, chunks.size() * storage::kChunkHeaderBytes);

  const tests::MemoryWatch watch;
  std::size_t next = 0;
  storage::ChunkSource source(storage::BlobKind::kStates, payload_bytes,
                              [&]() -> absl::StatusOr<std::span<const std::byte>> {
                                return next < chunks.size()
                                           ? std::span<const std::byte>(chunks[next++])
                                           : std::span<const std::byte>();
                              });
  std::vector<std::byte> read(payload_bytes);
  const absl::Status status = source.Read(read);
  tests::CheckErrorContract(status, absl::StatusCode::kDataLoss);
  if (status.ok()) tests::CheckErrorContract(source.Finish(), absl::StatusCode::kDataLoss);
  watch.CheckProportional(size, 64 << 10, 4);
  return 0;
}
