#include "storage/sql/tables/deleted_databases.h"

#include <fmt/format.h>

#include <limits>
#include <string>
#include <string_view>

#include "core/motion/error.h"
#include "storage/sql/tables/clip_text.h"

namespace motiondb::storage {
namespace {

constexpr std::int64_t kFreedPieceBytes = 4 << 20;
constexpr int kPieceRows = 256;
constexpr std::int64_t kBeforeAll = std::numeric_limits<std::int64_t>::max();

// Progress through the rows with chunks. The order is from the last key to the first: an extension
// is deleted before its build.
struct Place {
  std::int64_t owner = kBeforeAll;
  bool owner_is_done = true;
  // The last freed chunk of the owner.
  std::int64_t kind = -1;
  std::int64_t position = -1;
};

// Returns whether the same call may succeed later.
bool IsTransient(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsResourceExhausted(status) ||
         absl::IsCancelled(status);
}

// Frees one database.
class Freeing {
 public:
  Freeing(std::int64_t database_key, const TransactionRunner& write,
          const core::Cancelled& cancelled)
      : key_(database_key), write_(write), cancelled_(cancelled) {}

  // DATA_LOSS if some rows cannot be read; these and the rows that refer to them stay.
  absl::Status Run() {
    MOTIONDB_RETURN_IF_ERROR(FreeRows(
        "model_clip WHERE (model_key, position) IN (SELECT model_key, position FROM model_clip "
        "WHERE model_key IN (SELECT model_key FROM model WHERE database_key = ?) LIMIT ?)"));
    for (const std::string_view table : {"model", "clip", "skeleton"}) {
      MOTIONDB_RETURN_IF_ERROR(FreeOwners(table));
    }
    for (const std::string_view table : {"segment", "tombstone", "edit"}) {
      MOTIONDB_RETURN_IF_ERROR(FreeRows(
          fmt::format("{0} WHERE {0}_key IN (SELECT {0}_key FROM {0} WHERE database_key = ? LIMIT "
                      "?)",
                      table)));
    }
    MOTIONDB_RETURN_IF_ERROR(
        FreeRows("operation WHERE sequence IN (SELECT sequence FROM operation WHERE "
                 "database_key = ? LIMIT ?)"));
    if (!data_loss_.ok()) return data_loss_;
    return write_([&](Connection& connection) {
      return connection.Query("DELETE FROM database WHERE database_key = ? AND deleted = 1", key_)
          .Run();
    });
  }

 private:
  // Runs one transaction. CANCELLED if cancelled before it.
  absl::Status Write(const std::function<absl::Status(Connection&)>& piece) {
    if (cancelled_ && cancelled_())
      return absl::CancelledError("cancelled while deleted databases were freed");
    return write_(piece);
  }

  // Records that some rows stay because of `status`. Returns transient errors.
  absl::Status Leave(const absl::Status& status) {
    if (IsTransient(status)) return status;
    if (data_loss_.ok()) data_loss_ = absl::DataLossError(status.message());
    return absl::OkStatus();
  }

  // Deletes small rows. `what`: table and condition with two parameters, database key and limit.
  absl::Status FreeRows(std::string_view what) {
    const std::string sql = fmt::format("DELETE FROM {}", what);
    bool more = true;
    while (more) {
      const absl::Status freed = Write([&](Connection& connection) -> absl::Status {
        MOTIONDB_RETURN_IF_ERROR(connection.Query(sql, key_, kPieceRows).Run());
        more = connection.changes() > 0;
        return absl::OkStatus();
      });
      if (!freed.ok()) return Leave(freed);
    }
    return absl::OkStatus();
  }

  // Deletes the database's rows of a table, each after its chunks.
  absl::Status FreeOwners(std::string_view table) {
    Place place;
    bool more = true;
    while (more) {
      Place reached = place;
      const auto free_rows = [&](int rows) {
        reached = place;
        reached_any_ = false;
        freed_rows_ = 0;
        return Write([&](Connection& connection) -> absl::Status {
          MOTIONDB_ASSIGN_OR_RETURN(more, FreePiece(connection, table, rows, reached));
          return absl::OkStatus();
        });
      };
      absl::Status freed = free_rows(kPieceRows);
      // The failed row rolled back the rows before it: free these again, without it.
      if (!freed.ok() && !IsTransient(freed) && freed_rows_ > 0) freed = free_rows(freed_rows_);
      if (!freed.ok()) {
        MOTIONDB_RETURN_IF_ERROR(Leave(freed));
        // Continue after the row that stays. If it could not even be found, stop.
        if (!reached_any_) return absl::OkStatus();
        more = true;
      }
      place = reached;
    }
    return absl::OkStatus();
  }

  // Frees up to `rows` chunks and rows from `place` on, at most about kFreedPieceBytes. Returns
  // false at the end.
  absl::StatusOr<bool> FreePiece(Connection& connection, std::string_view table, int rows,
                                 Place& place) {
    std::int64_t bytes = 0;
    for (; freed_rows_ < rows && bytes < kFreedPieceBytes; ++freed_rows_) {
      if (place.owner_is_done) {
        MOTIONDB_ASSIGN_OR_RETURN(const bool found, FindOwner(connection, table, place));
        if (!found) return false;
      }
      MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t freed, FreeNext(connection, table, place));
      bytes += freed;
    }
    return true;
  }

  absl::StatusOr<bool> FindOwner(Connection& connection, std::string_view table, Place& place) {
    Statement row = connection.Query(
        fmt::format("SELECT {0}_key FROM {0} WHERE database_key = ? AND {0}_key < ? "
                    "ORDER BY {0}_key DESC LIMIT 1",
                    table),
        key_, place.owner);
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (found) place = {.owner = row.Integer(0), .owner_is_done = false};
    return found;
  }

  // Frees the owner's next chunk, or the owner if no chunk is left. Returns the freed bytes.
  absl::StatusOr<std::int64_t> FreeNext(Connection& connection, std::string_view table,
                                        Place& place) {
    std::int64_t chunk_key = 0;
    std::int64_t bytes = 0;
    {
      Statement chunk = connection.Query(
          fmt::format("SELECT chunk_key, kind, position, length(chunk) FROM {0}_chunk WHERE "
                      "{0}_key = ? AND (kind, position) > (?, ?) ORDER BY kind, position LIMIT 1",
                      table),
          place.owner, place.kind, place.position);
      const auto found = chunk.Step();
      if (!found.ok()) {
        // Its chunks cannot be listed: it stays.
        place.owner_is_done = true;
        reached_any_ = true;
        return found.status();
      }
      if (*found) {
        chunk_key = chunk.Integer(0);
        place.kind = chunk.Integer(1);
        place.position = chunk.Integer(2);
        bytes = chunk.Integer(3);
      } else {
        place.owner_is_done = true;
      }
    }
    reached_any_ = true;
    if (place.owner_is_done) {
      if (table == "clip") MOTIONDB_RETURN_IF_ERROR(DeleteClipText(connection, place.owner));
      MOTIONDB_RETURN_IF_ERROR(
          connection.Query(fmt::format("DELETE FROM {0} WHERE {0}_key = ?", table), place.owner)
              .Run());
    } else {
      MOTIONDB_RETURN_IF_ERROR(
          connection
              .Query(fmt::format("DELETE FROM {}_chunk WHERE chunk_key = ?", table), chunk_key)
              .Run());
    }
    return bytes;
  }

  const std::int64_t key_;
  const TransactionRunner& write_;
  const core::Cancelled& cancelled_;
  absl::Status data_loss_;  // the first error because of which a row stays
  // The last transaction: whether it found something to free, and the number of freed rows.
  bool reached_any_ = false;
  int freed_rows_ = 0;
};

// Finds the next deleted database after a key that no server imports; 0 if there is none.
absl::Status FindDeleted(Connection& connection, StagedDatabases& staged, std::int64_t after,
                         std::int64_t& key) {
  Statement row = connection.Query(
      "SELECT database_key FROM database WHERE deleted = 1 AND database_key > ? "
      "ORDER BY database_key",
      after);
  key = 0;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return absl::OkStatus();
    if (staged.Contains(row.Integer(0))) continue;
    MOTIONDB_ASSIGN_OR_RETURN(const bool taken, connection.TakeHidden(row.Integer(0)));
    if (!taken) continue;
    key = row.Integer(0);
    return absl::OkStatus();
  }
}

}  // namespace

absl::Status FreeDeletedDatabases(const TransactionRunner& write, StagedDatabases& staged,
                                  const core::Cancelled& cancelled) {
  absl::Status data_loss;
  std::int64_t key = 0;
  while (true) {
    MOTIONDB_RETURN_IF_ERROR(
        write([&](Connection& connection) { return FindDeleted(connection, staged, key, key); }));
    if (key == 0) return data_loss;
    const absl::Status freed = Freeing(key, write, cancelled).Run();
    if (!freed.ok() && !absl::IsDataLoss(freed)) return freed;
    data_loss.Update(freed);
  }
}

}  // namespace motiondb::storage
