#include "storage/sqlite/sqlite_motion_store.h"

#include <catch2/catch.hpp>

#include "tests/storage/motion_store_conformance.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests {
namespace {

storage::SqliteOptions AtPutTime() {
  storage::SqliteOptions options;
  options.now_us = [] { return kPutTime; };
  return options;
}

class InMemory final : public StoreUnderTest {
 public:
  storage::MotionStore& Get() override { return *store_; }

 private:
  std::unique_ptr<storage::SqliteMotionStore> store_ =
      Require(storage::SqliteMotionStore::Open(":memory:", AtPutTime()));
};

class OnFile final : public StoreUnderTest {
 public:
  storage::MotionStore& Get() override { return *store_; }

 private:
  StoreFile file_;
  std::unique_ptr<storage::SqliteMotionStore> store_ = file_.Open(AtPutTime());
};

// Closed and opened before every single call.
class Reopened final : public StoreUnderTest {
 public:
  storage::MotionStore& Get() override {
    store_.reset();
    store_ = file_.Open(AtPutTime());
    return *store_;
  }

 private:
  StoreFile file_;
  std::unique_ptr<storage::SqliteMotionStore> store_;
};

}  // namespace

TEST_CASE("SqliteMotionStore: keeps the contract in memory", "[storage][conformance]") {
  TestMotionStore([] { return std::make_unique<InMemory>(); });
}

TEST_CASE("SqliteMotionStore: keeps the contract on a file", "[storage][conformance]") {
  TestMotionStore([] { return std::make_unique<OnFile>(); });
}

TEST_CASE("SqliteMotionStore: keeps the contract when opened anew before each call",
          "[storage][conformance]") {
  TestMotionStore([] { return std::make_unique<Reopened>(); });
}

}  // namespace motiondb::tests
