#include "storage/sqlite/sqlite_verifier.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/motion/error.h"
#include "storage/mutex.h"
#include "storage/sqlite/clip_search.h"
#include "storage/sqlite/file_faults.h"
#include "storage/sqlite/index_corruption.h"
#include "storage/sqlite/row_checksum.h"
#include "storage/sqlite/schema.h"
#include "storage/sqlite/sqlite_connection.h"

namespace motiondb::storage {
namespace {

// Makes long SQLite statements cancellable during its lifetime: a thread polls `cancelled` and
// interrupts SQLite, which has no callback while it checks the pages of a file.
class Interruptible {
 public:
  Interruptible(Connection& connection, const core::Cancelled& cancelled) {
    if (!cancelled) return;
    watcher_ = std::jthread([&connection, &cancelled](const std::stop_token& stop) {
      Mutex mutex;
      std::condition_variable_any ended;
      std::unique_lock lock(mutex);
      while (!stop.stop_requested()) {
        if (cancelled()) sqlite3_interrupt(HandleOf(connection));
        ended.wait_for(lock, stop, std::chrono::milliseconds(50), [] { return false; });
      }
    });
  }

 private:
  std::jthread watcher_;
};

}  // namespace

absl::Status SqliteVerifier::CheckSchema(Connection& connection) {
  return storage::CheckSchema(connection);
}

absl::Status SqliteVerifier::CheckFile(Connection& connection, std::int64_t& size) {
  const Interruptible interruptible(connection, cancelled());
  MOTIONDB_ASSIGN_OR_RETURN(const auto pages, connection.QueryInteger("PRAGMA page_count"));
  MOTIONDB_ASSIGN_OR_RETURN(const auto page_bytes, connection.QueryInteger("PRAGMA page_size"));
  size = std::max<std::int64_t>(1, pages * page_bytes);
  std::vector<std::string> faults;
  const absl::Status checked = FindFileFaults(connection, faults);
  for (const std::string& fault : faults) {
    MOTIONDB_RETURN_IF_ERROR(Note("", core::DataLoss("the file: {}", fault)));
  }
  return checked;
}

absl::Status SqliteVerifier::CheckSearchIndex(Connection& connection) {
  const Interruptible interruptible(connection, cancelled());
  const auto wrong = FindWrongWords(connection);
  index_is_readable_ = wrong.ok();
  if (!wrong.ok()) return Note("", OfCorruptIndex(wrong.status()));
  for (const std::string& resource : *wrong) {
    MOTIONDB_RETURN_IF_ERROR(
        Note(resource, OfCorruptIndex(core::DataLoss("its words differ from the clip"))));
  }
  return absl::OkStatus();
}

absl::Status SqliteVerifier::CheckText(Connection& connection, std::int64_t clip_key,
                                       const ClipText& text) {
  if (!index_is_readable_) return absl::OkStatus();
  return OfCorruptIndex(CheckClipText(connection, clip_key, text));
}

absl::Status SqliteVerifier::OfCorruptIndex(const absl::Status& status) {
  const absl::Status placed = In("search index", OfSearchIndex(status));
  if (!absl::IsDataLoss(placed)) return placed;
  if (on_corrupt_index_) on_corrupt_index_();
  return core::DataLoss("{}; the next change or search rebuilds the index from the clips",
                        std::string(placed.message()));
}

absl::StatusOr<std::vector<ChangedRow>> SqliteVerifier::FindChanged(Connection& connection,
                                                                    std::string_view table) {
  const Interruptible interruptible(connection, cancelled());
  return FindChangedRows(connection, table);
}

}  // namespace motiondb::storage
