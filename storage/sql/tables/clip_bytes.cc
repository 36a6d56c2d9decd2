#include "storage/sql/tables/clip_bytes.h"

#include <vector>

#include "core/motion/error.h"
#include "storage/sql/connection/transaction.h"

namespace motiondb::storage {
namespace {

constexpr int kBatch = 1000;

absl::StatusOr<std::vector<std::int64_t>> NextUncounted(Connection& connection,
                                                        std::int64_t after) {
  Statement row = connection.Query(
      "SELECT clip_key FROM clip WHERE byte_count IS NULL AND deleted = 0 AND clip_key > ? "
      "ORDER BY clip_key LIMIT ?",
      after, kBatch);
  std::vector<std::int64_t> keys;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return keys;
    keys.push_back(row.Integer(0));
  }
}

absl::Status CountEach(Connection& connection, const std::vector<std::int64_t>& keys) {
  return InTransaction(connection, Transaction::Kind::kWrite, [&](Connection&) -> absl::Status {
    for (const std::int64_t key : keys) MOTIONDB_RETURN_IF_ERROR(UpdateByteCount(connection, key));
    return absl::OkStatus();
  });
}

}  // namespace

absl::Status UpdateByteCount(Connection& connection, std::int64_t clip_key) {
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("UPDATE clip SET byte_count = (SELECT COALESCE(sum(length(chunk)), 0) FROM "
                 "clip_chunk "
                 "WHERE clip_chunk.clip_key = clip.clip_key) WHERE clip_key = ?",
                 clip_key)
          .RunLater());
  return connection.SetRowChecksum("clip", clip_key);
}

void FillMissingByteCounts(Connection& connection) {
  for (std::int64_t last = 0;;) {
    const auto keys = NextUncounted(connection, last);
    if (!keys.ok() || keys->empty()) return;
    last = keys->back();
    const absl::Status counted = CountEach(connection, *keys);
    if (counted.ok()) continue;
    if (!absl::IsDataLoss(counted)) return;
    // After DATA_LOSS the transaction cannot continue: count each clip in its own transaction.
    for (const std::int64_t key : *keys) {
      if (!absl::IsDataLoss(CountEach(connection, {key}))) continue;
      InTransaction(connection, Transaction::Kind::kWrite, [&](Connection&) -> absl::Status {
        MOTIONDB_RETURN_IF_ERROR(
            connection.Query("UPDATE clip SET byte_count = 0 WHERE clip_key = ?", key).Run());
        return connection.SetRowChecksum("clip", key);
      }).IgnoreError();
    }
  }
}

}  // namespace motiondb::storage
