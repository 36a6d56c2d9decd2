#include "storage/sql/tables/skeleton_table.h"

#include <algorithm>
#include <utility>

#include "core/motion/error.h"
#include "storage/blob/checksums.h"
#include "storage/blob/clip_codec.h"
#include "storage/sql/tables/chunk_table.h"
#include "storage/sql/tables/database_table.h"

namespace motiondb::storage {

namespace {

constexpr std::size_t kMaxIdBytes = 100;  // leaves room for "-2"

BlobOwner Owner(std::int64_t key) { return {"skeleton", key}; }

// Returns a valid resource id: replaces characters other than letters, digits, '-', '_', '.' by
// '_'.
std::string IdFromName(std::string name) {
  if (name.empty()) return "skeleton";
  name.resize(std::min(name.size(), kMaxIdBytes));
  for (char& c : name) {
    const bool fit = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                     c == '-' || c == '_' || c == '.';
    if (!fit) c = '_';
  }
  return name;
}

absl::StatusOr<core::Skeleton> Decode(Connection& connection, std::int64_t key,
                                      const std::string& database, const std::string& id) {
  absl::StatusOr<core::Skeleton> skeleton = absl::UnknownError("not read");
  const absl::Status read =
      ReadBlob(connection, Owner(key), BlobKind::kSkeleton, [&](ByteSource& source) {
        skeleton = DecodeSkeleton(source);
        return skeleton.status();
      });
  if (!read.ok()) return In(fmt::format("database '{}', skeleton '{}'", database, id), read);
  return skeleton;
}

// Returns the key of the skeleton with the encoding `encoded`; 0 if there is none.
absl::StatusOr<std::int64_t> FindAlike(Connection& connection, std::int64_t database_key,
                                       const std::string& encoded, std::uint32_t crc) {
  Statement row = connection.Query(
      "SELECT skeleton_key FROM skeleton WHERE database_key = ? AND encoded_crc = ?", database_key,
      crc);
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return 0;
    const auto stored = ReadBlob(connection, Owner(row.Integer(0)), BlobKind::kSkeleton);
    // A corrupt skeleton equals no other; it must not prevent adding a clip.
    if (stored.ok() && *stored == encoded) return row.Integer(0);
    if (!stored.ok() && !absl::IsDataLoss(stored.status())) return stored.status();
  }
}

}  // namespace

absl::StatusOr<std::int64_t> FindOrInsertSkeleton(Connection& connection, std::int64_t database_key,
                                                  const core::Skeleton& skeleton) {
  StringSink encoded;
  MOTIONDB_RETURN_IF_ERROR(EncodeSkeleton(skeleton, encoded));
  const std::uint32_t crc = Crc32(std::as_bytes(std::span(encoded.bytes())));
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t alike,
                            FindAlike(connection, database_key, encoded.bytes(), crc));
  if (alike != 0) return alike;

  MOTIONDB_ASSIGN_OR_RETURN(
      const std::string id,
      ChooseFreeId(connection, "SELECT 1 FROM skeleton WHERE database_key = ? AND id = ?",
                   database_key, IdFromName(skeleton.name())));
  MOTIONDB_ASSIGN_OR_RETURN(
      const std::int64_t key,
      connection.Insert("skeleton_key",
                        "INSERT INTO skeleton (database_key, id, encoded_crc) VALUES (?, ?, ?)",
                        database_key, id, crc));
  MOTIONDB_RETURN_IF_ERROR(connection.SetRowChecksum("skeleton", key));
  MOTIONDB_RETURN_IF_ERROR(WriteBlob(connection, Owner(key), BlobKind::kSkeleton, encoded.bytes()));
  return key;
}

absl::StatusOr<core::Skeleton> SelectSkeleton(Connection& connection, const std::string& database,
                                              const std::string& id) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  Statement row = connection.Query(
      "SELECT skeleton_key FROM skeleton WHERE database_key = ? AND id = ?", database_key, id);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found)
    return core::WithReason("SKELETON_NOT_FOUND",
                            core::NotFound("database '{}' has no skeleton '{}'", database, id));
  return Decode(connection, row.Integer(0), database, id);
}

absl::StatusOr<std::vector<SkeletonRecord>> SelectSkeletons(Connection& connection,
                                                            const std::string& database,
                                                            const Page& page) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  Statement row = connection.Query(
      "SELECT skeleton_key, id FROM skeleton WHERE database_key = ? AND id > ? ORDER BY id",
      database_key, page.after);
  std::vector<SkeletonRecord> records;
  while (static_cast<int>(records.size()) < page.limit) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) break;
    std::string id = row.Text(1);
    auto skeleton = Decode(connection, row.Integer(0), database, id);
    // Skip a corrupt skeleton.
    if (absl::IsDataLoss(skeleton.status())) continue;
    if (!skeleton.ok()) return skeleton.status();
    records.push_back({std::move(id), *std::move(skeleton)});
  }
  return records;
}

absl::Status DeleteUnusedSkeleton(Connection& connection, std::int64_t skeleton_key) {
  return connection
      .Query(
          "DELETE FROM skeleton WHERE skeleton_key = ? AND NOT EXISTS "
          "(SELECT 1 FROM clip WHERE clip.skeleton_key = skeleton.skeleton_key)",
          skeleton_key)
      .Run();
}

absl::StatusOr<std::string> ChooseFreeId(Connection& connection, std::string_view taken_sql,
                                         std::int64_t database_key, const std::string& wanted) {
  const auto id_of = [&](std::int64_t number) {
    return number == 1 ? wanted : fmt::format("{}-{}", wanted, number);
  };
  const auto is_taken = [&](std::int64_t number) {
    return connection.Query(taken_sql, database_key, id_of(number)).Step();
  };
  // Exponential, then binary search: O(log n) queries for n taken ids.
  std::int64_t taken = 0;
  std::int64_t free = 1;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool is_there, is_taken(free));
    if (!is_there) break;
    taken = free;
    free *= 2;
  }
  while (free - taken > 1) {
    const std::int64_t middle = taken + (free - taken) / 2;
    MOTIONDB_ASSIGN_OR_RETURN(const bool is_there, is_taken(middle));
    (is_there ? taken : free) = middle;
  }
  return id_of(free);
}

}  // namespace motiondb::storage
