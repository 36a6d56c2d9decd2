#include "storage/sqlite/sqlite_verifier.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/motion/error.h"
#include "storage/mutex.h"
#include "storage/sql/connection/connection.h"
#include "storage/sqlite/clip_search.h"
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

// Faults in the structure of a store's file: pages, tables, indices and references.

constexpr std::int64_t kMaxFaults = 20;

// Returns a text of integrity_check without its lines about pages that are not used, which are not
// corrupt; empty if there is no other line.
std::string WithoutUnusedPages(std::string_view text) {
  constexpr std::string_view kTitle = "*** in database main ***";
  std::string rest;
  bool has_fault = false;
  while (!text.empty()) {
    const std::size_t size = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, size);
    text.remove_prefix(std::min(size + 1, text.size()));
    // "Page 7 is never used"; since SQLite 3.42 "Page 7: never used".
    if (line.starts_with("Page ") && line.ends_with(" never used")) continue;
    has_fault = has_fault || line != kTitle;
    rest += fmt::format("{}{}", rest.empty() ? "" : "\n", line);
  }
  return has_fault ? rest : "";
}

// Sets `faults` to those of an integrity check with a limit. Returns whether pages are not used.
absl::StatusOr<bool> CheckIntegrity(Connection& connection, std::int64_t limit,
                                    std::vector<std::string>& faults) {
  faults.clear();
  bool has_unused = false;
  Statement row = connection.Query(fmt::format("PRAGMA integrity_check({})", limit));
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return has_unused;
    const std::string text = row.Text(0);
    if (text == "ok") continue;
    std::string fault = WithoutUnusedPages(text);
    has_unused = has_unused || fault != text;
    if (!fault.empty() && std::ssize(faults) < kMaxFaults) faults.push_back(std::move(fault));
  }
}

// Sets `faults` to the faults as texts: the first 20 of SQLite's integrity check, and rows that
// refer to missing ones. Pages that are not used are no fault. Reads the whole file. DATA_LOSS if
// the check cannot go on; `faults` then has those that it found before.
absl::Status FindFileFaults(Connection& connection, std::vector<std::string>& faults) {
  MOTIONDB_ASSIGN_OR_RETURN(const bool has_unused, CheckIntegrity(connection, kMaxFaults, faults));
  if (has_unused) {
    // Pages that a rebuild of the search index has left (RebuildClipText). SQLite counts them as
    // faults: look again for as many more.
    MOTIONDB_ASSIGN_OR_RETURN(const auto pages, connection.QueryInteger("PRAGMA page_count"));
    MOTIONDB_RETURN_IF_ERROR(CheckIntegrity(connection, pages + kMaxFaults, faults).status());
  }
  Statement reference = connection.Query("PRAGMA foreign_key_check");
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, reference.Step());
    if (!found) return absl::OkStatus();
    faults.push_back(fmt::format("row {} of table {} refers to a missing row of table {}",
                                 reference.Integer(1), reference.Text(0), reference.Text(2)));
  }
}

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
