#include "storage/sqlite/reader_pool.h"

#include <catch2/catch.hpp>

#include "storage/read_scope.h"
#include "storage/sqlite/store_file.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::reader_pool_test {

TEST_CASE("ReaderPool: who helps leaves one for whoever asks next", "[storage][concurrency]") {
  const StoreFile file;
  const auto store = file.Open();
  storage::ReaderPool pool(
      file.path(), Require(storage::IdentityOf(file.path())),
      [&] { return storage::OpenReader(file.path(), ""); }, 4);
  {
    const auto first = pool.Acquire();
    REQUIRE_OK(first);
    CHECK(pool.AcquireIdle().size() == 2);  // none was idle
    const auto helping = pool.AcquireIdle();
    CHECK(helping.size() == 2);  // two are open, one is not
    CHECK(pool.AcquireIdle().empty());
    REQUIRE_OK(pool.Acquire());
  }
  CHECK(pool.AcquireIdle().size() == 3);  // all are open
}

TEST_CASE("ReaderPool: who waits for a reader is cancelled, and takes none with it",
          "[storage][concurrency]") {
  const StoreFile file;
  const auto store = file.Open();
  storage::ReaderPool pool(
      file.path(), Require(storage::IdentityOf(file.path())),
      [&] { return storage::OpenReader(file.path(), ""); }, 1);
  {
    const auto only = pool.Acquire();
    REQUIRE_OK(only);
    int asked = 0;
    REQUIRE_ERROR(pool.Acquire([&] { return ++asked > 2; }), absl::StatusCode::kCancelled,
                  "no longer wanted");
    CHECK(asked == 3);
  }
  REQUIRE_OK(pool.Acquire([] { return true; }));  // it need not wait
}

TEST_CASE("ReadScope: a read that waits for its turn gives up with its caller",
          "[storage][concurrency]") {
  const StoreFile file;
  const auto store = file.Open({.reader_count = 1});
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  absl::Status waited;
  // Asked inside a read, which has the only reader.
  const auto read_meanwhile = [&] {
    const core::Cancelled gone = [] { return true; };
    const storage::ReadScope scope(gone);
    waited = store->ListDatabases({}).status();
    return true;
  };
  REQUIRE_ERROR(store->upkeep().BeginBackup(read_meanwhile), absl::StatusCode::kCancelled,
                "stopped");
  REQUIRE_ERROR(waited, absl::StatusCode::kCancelled, "no longer wanted");
  REQUIRE(Require(store->ListDatabases({})).size() == 1);
}

}  // namespace motiondb::tests::reader_pool_test
