#include "storage/sql/connection/reader_pool.h"

#include <catch2/catch.hpp>

#include "storage/sqlite/store_file.h"
#include "storage/thread_scopes.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::reader_pool_test {

TEST_CASE("ReaderPool: AcquireIdle leaves one connection for the next caller",
          "[storage][concurrency]") {
  const StoreFile file;
  const auto store = file.Open();
  storage::ReaderPool pool([&] { return storage::OpenReader(file.path(), ""); }, {}, 4);
  {
    const auto first = pool.Acquire();
    REQUIRE_OK(first);
    CHECK(pool.AcquireIdle().size() == 2);  // none was idle: opens two
    const auto helping = pool.AcquireIdle();
    CHECK(helping.size() == 2);  // two are idle, one can be opened
    CHECK(pool.AcquireIdle().empty());
    REQUIRE_OK(pool.Acquire());
  }
  CHECK(pool.AcquireIdle().size() == 3);  // all are open
}

TEST_CASE("ReaderPool: counts connections and waiting reads", "[storage][concurrency]") {
  const StoreFile file;
  const auto store = file.Open();
  storage::ReaderPool pool([&] { return storage::OpenReader(file.path(), ""); }, {}, 2);
  CHECK(pool.statistics().max_readers == 2);
  CHECK(pool.statistics().open_readers == 0);
  {
    const auto first = pool.Acquire();
    const auto second = pool.Acquire();
    CHECK(pool.statistics().leased_readers == 2);
    CHECK(pool.statistics().waited_reads == 0);
    int waiting = 0;
    REQUIRE_ERROR(pool.Acquire([&] { return ++waiting > 2; }), absl::StatusCode::kCancelled,
                  "cancelled");
    CHECK(pool.statistics().waited_reads == 1);
    CHECK(pool.statistics().wait_seconds > 0);
    CHECK(pool.statistics().waiting_reads == 0);
  }
  CHECK(pool.statistics().open_readers == 2);
  CHECK(pool.statistics().leased_readers == 0);
}

TEST_CASE("ReaderPool: waiting can be cancelled, and no connection is lost",
          "[storage][concurrency]") {
  const StoreFile file;
  const auto store = file.Open();
  storage::ReaderPool pool([&] { return storage::OpenReader(file.path(), ""); }, {}, 1);
  {
    const auto only = pool.Acquire();
    REQUIRE_OK(only);
    int polls = 0;
    REQUIRE_ERROR(pool.Acquire([&] { return ++polls > 2; }), absl::StatusCode::kCancelled,
                  "cancelled while it waited");
    CHECK(polls == 3);
  }
  REQUIRE_OK(pool.Acquire([] { return true; }));  // does not have to wait
}

TEST_CASE("ReadScope: a read that waits for a connection can be cancelled",
          "[storage][concurrency]") {
  const StoreFile file;
  const auto store = file.Open({.reader_count = 1});
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  absl::Status waited;
  // Called during a read that uses the only connection.
  const auto read_meanwhile = [&] {
    const core::Cancelled gone = [] { return true; };
    const storage::ReadScope scope(gone);
    waited = store->ListDatabases({}).status();
    return true;
  };
  REQUIRE_ERROR(store->maintenance().BeginBackup(read_meanwhile), absl::StatusCode::kCancelled,
                "cancelled while the store was copied");
  REQUIRE_ERROR(waited, absl::StatusCode::kCancelled, "cancelled while it waited");
  REQUIRE(Require(store->ListDatabases({})).size() == 1);
}

}  // namespace motiondb::tests::reader_pool_test
