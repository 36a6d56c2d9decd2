// SqliteMotionStore's way of adding clips: those that come while another change is being written
// share a transaction, and so a sync.
#include <algorithm>
#include <exception>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "storage/cancellable_lock.h"
#include "storage/sqlite/added_bytes.h"
#include "storage/sqlite/audit_table.h"
#include "storage/sqlite/clip_table.h"
#include "storage/sqlite/sqlite_motion_store.h"

namespace motiondb::storage {
namespace {

absl::StatusOr<ClipRecord> InsertWithRecord(Connection& connection, const NewClip& clip) {
  auto added = InsertClip(connection, clip);
  if (added.ok() && clip.audit) {
    MOTIONDB_RETURN_IF_ERROR(InsertAuditRecord(connection, clip.audit(*added)));
  }
  return added;
}

}  // namespace

absl::StatusOr<ClipRecord> SqliteMotionStore::AddClip(const NewClip& clip) {
  auto added = AddClipInTurn(clip);
  write_health_.Note(added.status());
  return added;
}

absl::StatusOr<ClipRecord> SqliteMotionStore::AddClipInTurn(const NewClip& clip) {
  Addition own{&clip, std::nullopt};
  {
    const std::lock_guard lock(additions_mutex_);
    additions_.push_back(&own);
  }
  // Whoever gets here first writes for all who wait, so that they share one sync.
  std::unique_lock writing(writer_mutex_, std::defer_lock);
  if (absl::Status turn = Lock(writing, clip.cancelled); !turn.ok()) {
    if (Withdraw(own)) return turn;
    // Somebody is at it.
    std::unique_lock lock(additions_mutex_);
    additions_over_.wait(lock, [&] { return own.is_over; });
    return own.added ? *std::move(own.added) : absl::StatusOr<ClipRecord>(std::move(turn));
  }
  if (!own.added) {
    std::vector<Addition*> together;
    const absl::Cleanup over = [&] {
      const std::lock_guard lock(additions_mutex_);
      for (Addition* const addition : together) addition->is_over = true;
      additions_over_.notify_all();
    };
    {
      const std::lock_guard lock(additions_mutex_);
      together.swap(additions_);
    }
    // Not there only where an exception kept the one who took it up from it.
    if (std::ranges::find(together, &own) == together.end()) together.push_back(&own);
    if (together.size() == 1 || !AddInOne(together)) AddEach(together, own);
  }
  return *std::move(own.added);
}

bool SqliteMotionStore::Withdraw(const Addition& addition) {
  const std::lock_guard lock(additions_mutex_);
  return std::erase(additions_, &addition) > 0;
}

bool SqliteMotionStore::AddInOne(const std::vector<Addition*>& additions) {
  // Kept apart until they are in the file: an addition that is told is acknowledged.
  std::vector<ClipRecord> records;
  std::int64_t added_bytes = 0;
  for (const Addition* const addition : additions) added_bytes += AddedBytes(*addition->clip);
  const auto insert_all = [&](Connection& connection) -> absl::Status {
    for (const Addition* const addition : additions) {
      MOTIONDB_ASSIGN_OR_RETURN(records.emplace_back(),
                                InsertWithRecord(connection, *addition->clip));
    }
    return absl::OkStatus();
  };
  try {
    if (!WriteHolding(insert_all, added_bytes).ok()) return false;
  } catch (const std::exception&) {
    return false;  // each meets its own by itself
  }
  for (std::size_t i = 0; i < additions.size(); ++i) additions[i]->added = std::move(records[i]);
  return true;
}

void SqliteMotionStore::AddEach(const std::vector<Addition*>& additions, const Addition& own) {
  for (Addition* const addition : additions) {
    try {
      addition->added = WriteHolding(
          [&](Connection& connection) { return InsertWithRecord(connection, *addition->clip); },
          AddedBytes(*addition->clip));
    } catch (const std::exception&) {
      // Another's is written by its own thread, which finds it without a result.
      if (addition == &own) throw;
    }
  }
}

}  // namespace motiondb::storage
