// Blobs in the tables clip_chunk, skeleton_chunk and model_chunk. The functions run in the caller's
// transaction.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "storage/blob/byte_stream.h"
#include "storage/blob/chunk_stream.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// The row that a blob belongs to and is deleted with.
struct BlobOwner {
  std::string_view table;  // "clip", "skeleton", "model"
  std::int64_t key = 0;
};

// Stores one chunk that ChunkSink made.
absl::Status WriteChunk(Connection& connection, const BlobOwner& owner, BlobKind kind,
                        std::uint32_t position, std::span<const std::byte> chunk);

// Stores the bytes that `encode` writes.
absl::Status WriteBlob(Connection& connection, const BlobOwner& owner, BlobKind kind,
                       const std::function<absl::Status(ByteSink&)>& encode);
absl::Status WriteBlob(Connection& connection, const BlobOwner& owner, BlobKind kind,
                       std::string_view bytes);

// Calls `decode` with the blob, which it reads to the end. DATA_LOSS names the kind and the chunk.
absl::Status ReadBlob(Connection& connection, const BlobOwner& owner, BlobKind kind,
                      const std::function<absl::Status(ByteSource&)>& decode);
absl::StatusOr<std::string> ReadBlob(Connection& connection, const BlobOwner& owner, BlobKind kind);
// Reads a blob of known size.
absl::Status ReadBlob(Connection& connection, const BlobOwner& owner, BlobKind kind,
                      std::int64_t bytes, const std::function<absl::Status(ByteSource&)>& decode);

// Returns the size of a blob; 0 if it has no chunks. Does not read the chunks.
absl::StatusOr<std::int64_t> BlobBytes(Connection& connection, const BlobOwner& owner,
                                       BlobKind kind);

// Returns the size of a blob from the number of its chunks and their size with headers. Negative if
// a chunk is shorter than its header.
std::int64_t PayloadBytes(std::int64_t chunks, std::int64_t chunk_bytes);

absl::Status DeleteBlob(Connection& connection, const BlobOwner& owner, BlobKind kind);

// Adds `place` to the message of an error: "database 'd', clip 'c': ...".
absl::Status In(std::string_view place, const absl::Status& status);

}  // namespace motiondb::storage
