// How SqlMotionStore runs work on a connection: Write and its variants on the writer thread,
// Read on a reader. Only for the sources of SqlMotionStore, whose header declares these
// templates.
#pragma once

#include <type_traits>
#include <utility>

#include "core/motion/error.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/sql_motion_store.h"
#include "storage/sql/tables/access_tables.h"
#include "storage/sql/tables/clip_table.h"
#include "storage/sql/tables/database_table.h"
#include "storage/thread_scopes.h"

namespace motiondb::storage {

template <typename Work>
auto SqlMotionStore::Write(Priority priority, const Work& work, const core::Cancelled& cancelled,
                           Added added) {
  using Result = std::invoke_result_t<Work, Connection&>;
  if (absl::Status writable = CheckIsWritable(); !writable.ok()) return Result(std::move(writable));
  Result written = writer_->Run(priority, cancelled,
                                [&](Connection& writer) { return Transact(writer, added, work); });
  write_health_.Note(StatusOf(written));
  return written;
}

// Whether work has changed something, and so has an audit entry.
template <typename Result>
bool HasEffect(const Result&) {
  return true;
}
inline bool HasEffect(const absl::StatusOr<EditRecord>& edit) { return edit->id != 0; }

template <typename Work>
auto SqlMotionStore::WriteWith(const WriteOptions& terms, const Work& work, Added added,
                               Priority priority) {
  const auto write = [&](Connection& connection) -> std::invoke_result_t<Work, Connection&> {
    auto result = work(connection);
    if (StatusOf(result).ok() && terms.database_id != 0) {
      MOTIONDB_RETURN_IF_ERROR(CheckHasDatabase(connection, terms.database_id));
    }
    if (StatusOf(result).ok() && HasEffect(result) && terms.audit != nullptr) {
      MOTIONDB_RETURN_IF_ERROR(InsertAuditRecord(connection, *terms.audit));
    }
    return result;
  };
  return Write(priority, write, terms.cancelled, added);
}

template <typename Work>
auto SqlMotionStore::WriteAndFree(const WriteOptions& terms, const Work& work, Added added) {
  auto freed = WriteWith(
      terms, [&](Connection& connection) { return work(connection, FreePolicy::kFree); }, added);
  if (!absl::IsDataLoss(StatusOf(freed))) return freed;
  return WriteWith(
      terms, [&](Connection& connection) { return work(connection, FreePolicy::kLeave); }, added);
}

template <typename Work>
auto SqlMotionStore::Read(const Work& work) {
  using Result = std::invoke_result_t<Work, Connection&>;
  if (readers_ == nullptr) {
    return writer_->Run(Priority::kOrdinary, ReadScope::cancelled(), [&](Connection& writer) {
      return InTransaction(writer, Transaction::Kind::kRead, work);
    });
  }
  const auto reader = readers_->Acquire(ReadScope::cancelled());
  if (!reader.ok()) return Result(reader.status());
  return InTransaction(reader->connection(), Transaction::Kind::kRead, work);
}

}  // namespace motiondb::storage
