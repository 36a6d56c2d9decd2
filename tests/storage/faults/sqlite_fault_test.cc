// A call that fails at any point changes nothing. The test installs faults when SQLite opens a
// connection (sqlite3_auto_extension), so the store needs no test code.
#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <string>
#include <utility>

#include "tests/storage/backup_bytes.h"
#include "tests/storage/conformance/exported_database_conformance.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::sqlite_fault_test {
namespace {

using absl::StatusCode;

// Steps of SQLite's virtual machine until the interrupt; 0: no interrupt.
int steps_left = 0;
// Maximum size of the file, in pages; 0: no limit.
int max_pages = 0;

// Whether the running statement began in a transaction.
bool began_in_transaction = false;

int NoteBegin(unsigned, void* connection, void*, void*) {
  began_in_transaction = sqlite3_get_autocommit(static_cast<sqlite3*>(connection)) == 0;
  return 0;
}

int CountSteps(void* connection) {
  // SQLite calls this again when a COMMIT returns: the commit is done and cannot be interrupted.
  const bool ended = sqlite3_get_autocommit(static_cast<sqlite3*>(connection)) != 0;
  if (began_in_transaction && ended) return 0;
  return steps_left > 0 && --steps_left == 0 ? 1 : 0;
}

int SetFaults(sqlite3* connection, const char**, const void*) {
  sqlite3_progress_handler(connection, 1, CountSteps, connection);
  sqlite3_trace_v2(connection, SQLITE_TRACE_STMT, NoteBegin, connection);
  if (max_pages > 0) {
    const std::string pragma = "PRAGMA max_page_count = " + std::to_string(max_pages);
    return sqlite3_exec(connection, pragma.c_str(), nullptr, nullptr, nullptr);
  }
  return SQLITE_OK;
}

std::string CountRows(const StoreFile& file) {
  std::string counts;
  for (const std::string table :
       {"database", "skeleton", "skeleton_chunk", "clip", "clip_chunk", "segment", "model",
        "model_layer", "model_clip", "model_chunk", "tombstone", "edit", "clip_text"}) {
    counts += file.Sql("SELECT count(*) FROM " + table) + " ";
  }
  return counts;
}

// Enables faults during its lifetime.
class Faults {
 public:
  Faults() { sqlite3_auto_extension(reinterpret_cast<void (*)()>(SetFaults)); }
  ~Faults() {
    sqlite3_reset_auto_extension();
    steps_left = 0;
    max_pages = 0;
  }
};

}  // namespace

TEST_CASE("SqliteMotionStore: a call that is interrupted at any step changes nothing",
          "[storage][fault]") {
  const Faults faults;
  const auto store = Require(storage::SqliteMotionStore::Open(":memory:"));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  const auto walk = SampleClip("d", "walk", 1);
  auto run = SampleClip("d", "run", 2);
  run.skeleton = SampleSkeleton("other");
  REQUIRE_OK(store->AddClip(walk));
  REQUIRE_OK(store->PutModel("d", SampleModel({walk})));

  const core::Model next = SampleModel({walk, run});
  const std::function<absl::Status()> calls[] = {
      [&] { return store->AddClip(run).status(); },
      [&] { return store->PutModel("d", next).status(); },
      [&] { return store->PutOperation(SampleOperation("d", "op")); },
      [&] { return store->DeleteClip("d", "walk").status(); },
      [&] { return store->DropModel("d"); },
  };
  for (const auto& call : calls) {
    const std::string before = Dump(*store);
    int interrupted = 0;
    // Interrupt later and later, until the call succeeds. Growing strides limit the duration.
    for (int steps = 1;; steps += 1 + steps / 20) {
      steps_left = steps;
      const absl::Status status = call();
      steps_left = 0;
      if (status.ok()) break;
      ++interrupted;
      if (Dump(*store) != before) FAIL("changed, after " << steps << " steps: " << status);
    }
    REQUIRE(interrupted > 10);
    REQUIRE(Dump(*store) != before);
  }
}

TEST_CASE("SqliteMotionStore: an import that is interrupted at any step shows and keeps nothing",
          "[storage][fault]") {
  const StoreFile source_file;
  const auto source = source_file.Open();
  FillWithEverything(*source, "d");
  const std::string bytes = Export(*source, "d");
  const Faults faults;
  const StoreFile file;
  const auto store = file.Open();
  FillWithEverything(*store, "kept");
  const std::string before = Dump(*store);
  const std::string rows = CountRows(file);
  const std::string files = file.OtherFiles();
  const auto remove = [&] {
    REQUIRE(DumpDatabase(*store, "new") == DumpDatabase(*source, "d"));
    REQUIRE_OK(store->DeleteDatabase("new"));
    REQUIRE_OK(store->PurgeDeletedDatabases({}));
  };
  constexpr int kMany = 1'000'000'000;
  steps_left = kMany;
  REQUIRE_OK(Import(*store, bytes, "new"));
  const int total = kMany - std::exchange(steps_left, 0);
  remove();
  int interrupted = 0;
  int staged = 0;
  const auto interrupt = [&](int steps) {
    steps_left = steps;
    const absl::Status status = Import(*store, bytes, "new");
    if (std::exchange(steps_left, 0) == 0) ++interrupted;
    INFO("after " << steps << " steps: " << status);
    if (status.ok()) remove();  // the interrupted step was not necessary
    if (Dump(*store) != before || file.OtherFiles() != files) FAIL("changed");
    if (CountRows(file) == rows) return status.ok();
    ++staged;
    REQUIRE_OK(store->PurgeDeletedDatabases({}));
    if (CountRows(file) != rows) FAIL("not purged");
    return status.ok();
  };
  // The step after which none is necessary.
  int end = 1;
  for (int high = total; end < high;) {
    const int middle = end + (high - end) / 2;
    interrupt(middle) ? high = middle : end = middle + 1;
  }
  // Small strides at both ends: the transaction that shows the database is short.
  for (int steps = 1; steps <= end; steps += 1 + std::min(steps, end - steps) / 10) {
    interrupt(steps);
  }
  REQUIRE(interrupted > 50);
  REQUIRE(staged > 0);
  REQUIRE(Findings(*store).empty());
  REQUIRE_OK(Import(*store, bytes, "new"));
  remove();
}

TEST_CASE("SqliteMotionStore: opening can be interrupted at any step and repeated",
          "[storage][fault]") {
  const Faults faults;
  int interrupted = 0;
  const StoreFile file;
  for (int steps = 1;; steps += 1 + steps / 10) {
    steps_left = steps;
    const auto store = file.TryOpen();
    steps_left = 0;
    if (store.ok()) break;
    ++interrupted;
  }
  REQUIRE(interrupted > 10);
  REQUIRE_OK(file.Open()->CreateDatabase(SampleDatabase("d")));
}

TEST_CASE("SqliteMotionStore: a full disk is reported and the change is rolled back",
          "[storage][fault]") {
  const Faults faults;
  const StoreFile file;
  max_pages = 60;  // 960 KiB
  const auto store = file.Open();
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store->AddClip(SampleClip("d", "walk", 1)));
  const std::string before = Dump(*store);
  auto large = SampleClip("d", "large", 2);
  large.file_bytes.assign(2'000'000, 'x');
  REQUIRE_ERROR(store->AddClip(large), StatusCode::kResourceExhausted, "full");
  REQUIRE(Dump(*store) == before);
  REQUIRE_OK(store->AddClip(SampleClip("d", "run", 3)));
}

}  // namespace motiondb::tests::sqlite_fault_test
