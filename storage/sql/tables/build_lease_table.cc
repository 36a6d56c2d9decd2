#include "storage/sql/tables/build_lease_table.h"

#include <algorithm>

#include "core/motion/error.h"

namespace motiondb::storage {
namespace {

struct LeaseRow {
  std::string holder;      // empty: released
  std::int64_t fence = 0;  // 0: there is no row
  std::int64_t expire_time_us = 0;
};

absl::StatusOr<LeaseRow> SelectLease(Connection& connection, std::int64_t database_key) {
  Statement row = connection.Query(
      "SELECT holder, fence, expire_time_us FROM build_lease WHERE database_key = ?", database_key);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return LeaseRow{};
  return LeaseRow{row.Text(0), row.Integer(1), row.Integer(2)};
}

// Fencing numbers begin with the key of their database, so that those of a deleted database are not
// valid for another one with its name.
constexpr int kFenceBits = 32;

std::int64_t NextFence(std::int64_t database_key, std::int64_t last_fence) {
  return std::max(last_fence, database_key << kFenceBits) + 1;
}

absl::Status LeaseIsLost(const LeaseRow& last, std::int64_t fence) {
  return absl::AbortedError(
      last.holder.empty()
          ? fmt::format("build lease {} has ended; the last one was {}", fence, last.fence)
          : fmt::format("build lease {} has ended; '{}' has lease {}", fence, last.holder,
                        last.fence));
}

// Sets the lease `fence`, if it is the last one and was not released. Returns whether it was.
absl::StatusOr<bool> SetLease(Connection& connection, std::int64_t database_key, std::int64_t fence,
                              const char* change, std::int64_t value) {
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query(fmt::format("UPDATE build_lease SET {} WHERE database_key = ? AND fence = ? AND "
                             "holder <> ''",
                             change),
                 value, database_key, fence)
          .Run());
  if (connection.changes() == 0) return false;
  MOTIONDB_RETURN_IF_ERROR(connection.SetRowChecksum("build_lease", database_key));
  return true;
}

}  // namespace

absl::StatusOr<std::int64_t> AcquireLease(Connection& connection, std::int64_t database_key,
                                          const std::string& holder, std::int64_t now_us,
                                          std::int64_t expire_time_us) {
  MOTIONDB_ASSIGN_OR_RETURN(const LeaseRow last, SelectLease(connection, database_key));
  const bool is_free =
      last.holder.empty() || last.holder == holder || last.expire_time_us <= now_us;
  if (!is_free) {
    return absl::AbortedError(fmt::format("'{}' has the build lease of the database", last.holder));
  }
  const std::int64_t fence = NextFence(database_key, last.fence);
  const char* const sql =
      last.fence == 0
          ? "INSERT INTO build_lease (holder, fence, expire_time_us, database_key) VALUES (?, ?, "
            "?, ?)"
          : "UPDATE build_lease SET holder = ?, fence = ?, expire_time_us = ? WHERE database_key "
            "= ?";
  MOTIONDB_RETURN_IF_ERROR(
      connection.Query(sql, holder, fence, expire_time_us, database_key).Run());
  MOTIONDB_RETURN_IF_ERROR(connection.SetRowChecksum("build_lease", database_key));
  return fence;
}

absl::Status RenewLease(Connection& connection, std::int64_t database_key, std::int64_t fence,
                        std::int64_t expire_time_us) {
  MOTIONDB_ASSIGN_OR_RETURN(const bool renewed, SetLease(connection, database_key, fence,
                                                         "expire_time_us = ?", expire_time_us));
  if (renewed) return absl::OkStatus();
  MOTIONDB_ASSIGN_OR_RETURN(const LeaseRow last, SelectLease(connection, database_key));
  return LeaseIsLost(last, fence);
}

absl::Status ReleaseLease(Connection& connection, std::int64_t database_key, std::int64_t fence) {
  return SetLease(connection, database_key, fence, "holder = '', expire_time_us = ?", 0).status();
}

absl::Status CheckFence(Connection& connection, std::int64_t database_key, std::int64_t fence) {
  MOTIONDB_ASSIGN_OR_RETURN(const LeaseRow last, SelectLease(connection, database_key));
  const bool is_of_another = fence != 0 && fence >> kFenceBits != database_key;
  return fence < last.fence || is_of_another ? LeaseIsLost(last, fence) : absl::OkStatus();
}

}  // namespace motiondb::storage
