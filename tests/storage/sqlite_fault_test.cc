// A call that fails at any point leaves all as it was. Faults are set on connections as SQLite
// opens them (sqlite3_auto_extension), so the store itself knows nothing of them.
#include <catch2/catch.hpp>
#include <functional>
#include <string>

#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::sqlite_fault_test {
namespace {

using absl::StatusCode;

// Steps of SQLite's machine until everything is interrupted; 0 for never.
int steps_left = 0;
// Largest size of the file, in pages; 0 for any.
int most_pages = 0;

// Whether the running statement was begun in a transaction.
bool began_in_transaction = false;

int NoteBegin(unsigned, void* connection, void*, void*) {
  began_in_transaction = sqlite3_get_autocommit(static_cast<sqlite3*>(connection)) == 0;
  return 0;
}

int CountSteps(void* connection) {
  // SQLite asks again as a COMMIT returns: it has done its work, which no fault could undo.
  const bool ended = sqlite3_get_autocommit(static_cast<sqlite3*>(connection)) != 0;
  if (began_in_transaction && ended) return 0;
  return steps_left > 0 && --steps_left == 0 ? 1 : 0;
}

int SetFaults(sqlite3* connection, const char**, const void*) {
  sqlite3_progress_handler(connection, 1, CountSteps, connection);
  sqlite3_trace_v2(connection, SQLITE_TRACE_STMT, NoteBegin, connection);
  if (most_pages > 0) {
    const std::string pragma = "PRAGMA max_page_count = " + std::to_string(most_pages);
    return sqlite3_exec(connection, pragma.c_str(), nullptr, nullptr, nullptr);
  }
  return SQLITE_OK;
}

// Faults are possible while this lives.
class Faults {
 public:
  Faults() { sqlite3_auto_extension(reinterpret_cast<void (*)()>(SetFaults)); }
  ~Faults() {
    sqlite3_reset_auto_extension();
    steps_left = 0;
    most_pages = 0;
  }
};

}  // namespace

TEST_CASE("SqliteMotionStore: a call interrupted at any step changes nothing", "[storage][fault]") {
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
    // Further and further, until the call gets through. Strides keep it short.
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

TEST_CASE("SqliteMotionStore: opening that is interrupted at any step can be done again",
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

TEST_CASE("SqliteMotionStore: a full disk is said and nothing is half done", "[storage][fault]") {
  const Faults faults;
  const StoreFile file;
  most_pages = 60;  // 960 KiB
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
