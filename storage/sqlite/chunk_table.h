// Blobs in their tables: clip_chunk, skeleton_chunk and model_chunk. Functions keep no state; they
// run in the transaction of their caller.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "storage/blob/byte_stream.h"
#include "storage/blob/chunk_stream.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

// What a blob belongs to, and is deleted with.
struct BlobOwner {
  std::string_view table;  // "clip", "skeleton", "model"
  std::int64_t key = 0;
};

// Stores one chunk of a blob, as ChunkSink makes it.
absl::Status WriteChunk(Connection& connection, const BlobOwner& owner, BlobKind kind,
                        std::uint32_t position, std::span<const std::byte> chunk);

// Stores what `encode` writes.
absl::Status WriteBlob(Connection& connection, const BlobOwner& owner, BlobKind kind,
                       const std::function<absl::Status(ByteSink&)>& encode);
absl::Status WriteBlob(Connection& connection, const BlobOwner& owner, BlobKind kind,
                       std::string_view bytes);

// Hands the blob to `decode`, which reads it to its end. DATA_LOSS names the kind and the chunk.
absl::Status ReadBlob(Connection& connection, const BlobOwner& owner, BlobKind kind,
                      const std::function<absl::Status(ByteSource&)>& decode);
absl::StatusOr<std::string> ReadBlob(Connection& connection, const BlobOwner& owner, BlobKind kind);
// The same of a blob that is known to have so many bytes.
absl::Status ReadBlob(Connection& connection, const BlobOwner& owner, BlobKind kind,
                      std::int64_t bytes, const std::function<absl::Status(ByteSource&)>& decode);

// Bytes of a blob; 0 if it has no chunks. Reads none of them.
absl::StatusOr<std::int64_t> BlobBytes(Connection& connection, const BlobOwner& owner,
                                       BlobKind kind);

// Bytes of a blob whose chunks are so many and have so many bytes with their headers; less than 0
// where a chunk is cut short.
std::int64_t PayloadBytes(std::int64_t chunks, std::int64_t chunk_bytes);

absl::Status DeleteBlob(Connection& connection, const BlobOwner& owner, BlobKind kind);

// `status`, and where it is an error, where: "database 'd', clip 'c': ...".
absl::Status In(std::string_view place, const absl::Status& status);

}  // namespace motiondb::storage
