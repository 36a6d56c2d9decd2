#include "storage/sql/tables/chunk_table.h"

#include <optional>

#include "core/motion/error.h"
#include "storage/blob/chunk_stream.h"

namespace motiondb::storage {

absl::Status WriteChunk(Connection& connection, const BlobOwner& owner, BlobKind kind,
                        std::uint32_t position, std::span<const std::byte> chunk) {
  return connection
      .Query(fmt::format("INSERT INTO {0}_chunk ({0}_key, kind, position, chunk) "
                         "VALUES (?, ?, ?, ?)",
                         owner.table),
             owner.key, static_cast<int>(kind), position, chunk)
      .RunLater();
}

absl::Status WriteBlob(Connection& connection, const BlobOwner& owner, BlobKind kind,
                       const std::function<absl::Status(ByteSink&)>& encode) {
  ChunkSink sink(kind, [&](std::uint32_t position, std::span<const std::byte> chunk) {
    return WriteChunk(connection, owner, kind, position, chunk);
  });
  MOTIONDB_RETURN_IF_ERROR(encode(sink));
  return sink.Finish();
}

absl::Status WriteBlob(Connection& connection, const BlobOwner& owner, BlobKind kind,
                       std::string_view bytes) {
  return WriteBlob(connection, owner, kind, [&](ByteSink& sink) {
    return sink.Write(std::as_bytes(std::span(bytes.data(), bytes.size())));
  });
}

absl::Status ReadBlob(Connection& connection, const BlobOwner& owner, BlobKind kind,
                      const std::function<absl::Status(ByteSource&)>& decode) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t bytes, BlobBytes(connection, owner, kind));
  return ReadBlob(connection, owner, kind, bytes, decode);
}

absl::Status ReadBlob(Connection& connection, const BlobOwner& owner, BlobKind kind,
                      std::int64_t bytes, const std::function<absl::Status(ByteSource&)>& decode) {
  const std::string sql = fmt::format(
      "SELECT position, chunk FROM {0}_chunk WHERE {0}_key = ? AND kind = ? AND "
      "position >= ? ORDER BY position LIMIT ?",
      owner.table);
  const std::int64_t batch = connection.max_chunk_rows();
  const auto query = [&](std::int64_t position) {
    return connection.Query(sql, owner.key, static_cast<int>(kind), position, batch);
  };
  std::optional<Statement> rows;
  rows.emplace(query(0));
  std::int64_t count = 0;  // of rows of this batch
  std::int64_t next = 0;   // the position after the last row
  ChunkSource source(kind, static_cast<std::uint64_t>(bytes),
                     [&]() -> absl::StatusOr<std::span<const std::byte>> {
                       if (count == batch) {
                         rows.reset();  // before the query: it gives the prepared statement back
                         rows.emplace(query(next));
                         count = 0;
                       }
                       MOTIONDB_ASSIGN_OR_RETURN(const bool row, rows->Step());
                       if (!row) return std::span<const std::byte>();
                       ++count;
                       next = rows->Integer(0) + 1;
                       return rows->Blob(1);
                     });
  return decode(source);
}

absl::StatusOr<std::string> ReadBlob(Connection& connection, const BlobOwner& owner,
                                     BlobKind kind) {
  std::string bytes;
  const auto decode = [&](ByteSource& source) -> absl::Status {
    bytes.resize(source.remaining());
    MOTIONDB_RETURN_IF_ERROR(source.Read(std::as_writable_bytes(std::span(bytes))));
    return source.Finish();
  };
  MOTIONDB_RETURN_IF_ERROR(ReadBlob(connection, owner, kind, decode));
  return bytes;
}

absl::StatusOr<std::int64_t> BlobBytes(Connection& connection, const BlobOwner& owner,
                                       BlobKind kind) {
  Statement total = connection.Query(
      fmt::format("SELECT count(*), COALESCE(sum(length(chunk)), 0) FROM {0}_chunk "
                  "WHERE {0}_key = ? AND kind = ?",
                  owner.table),
      owner.key, static_cast<int>(kind));
  MOTIONDB_RETURN_IF_ERROR(total.Step().status());
  const std::int64_t bytes = PayloadBytes(total.Integer(0), total.Integer(1));
  if (bytes < 0)
    return core::DataLoss("{}: a chunk is corrupt: it is shorter than its header", Describe(kind));
  return bytes;
}

std::int64_t PayloadBytes(std::int64_t chunks, std::int64_t chunk_bytes) {
  return chunk_bytes - chunks * static_cast<std::int64_t>(kChunkHeaderBytes);
}

absl::Status DeleteBlob(Connection& connection, const BlobOwner& owner, BlobKind kind) {
  return connection
      .Query(fmt::format("DELETE FROM {0}_chunk WHERE {0}_key = ? AND kind = ?", owner.table),
             owner.key, static_cast<int>(kind))
      .Run();
}

absl::Status In(std::string_view place, const absl::Status& status) {
  if (status.ok()) return status;
  absl::Status placed(status.code(), fmt::format("{}: {}", place, std::string(status.message())));
  status.ForEachPayload(
      [&](absl::string_view url, const absl::Cord& payload) { placed.SetPayload(url, payload); });
  return placed;
}

}  // namespace motiondb::storage
