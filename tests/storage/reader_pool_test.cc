#include "storage/sqlite/reader_pool.h"

#include <catch2/catch.hpp>

#include "storage/sqlite/store_file.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests {

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

}  // namespace motiondb::tests
