#include "storage/sqlite/sqlite_motion_store.h"

#include <catch2/catch.hpp>

#include "core/model/model_builder.h"
#include "tests/storage/conformance/motion_store_conformance.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::sqlite_motion_store_test {
namespace {

using absl::StatusCode;

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

// Closes and opens the store before each call.
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

TEST_CASE("SqliteMotionStore: conforms in memory", "[storage][conformance]") {
  TestMotionStore([] { return std::make_unique<InMemory>(); });
}

TEST_CASE("SqliteMotionStore: conforms on a file", "[storage][conformance]") {
  TestMotionStore([] { return std::make_unique<OnFile>(); });
}

TEST_CASE("SqliteMotionStore: conforms if it is reopened before each call",
          "[storage][conformance]") {
  TestMotionStore([] { return std::make_unique<Reopened>(); });
}

TEST_CASE("SqliteMotionStore: keeps the records of 1,000 models and of the builds that they extend",
          "[storage]") {
  constexpr int kKept = 1000;
  InMemory under_test;
  storage::MotionStore& store = under_test.Get();
  REQUIRE_OK(store.CreateDatabase(SampleDatabase("d")));
  const auto walk = SampleClip("d", "walk", 1);
  const auto jump = SampleClip("d", "jump", 2);
  REQUIRE_OK(store.AddClip(walk));
  REQUIRE_OK(store.AddClip(jump));
  const core::Model built = SampleModel({walk});
  const core::Model extended = Require(core::ExtendModel(
      built, {{jump.record.id, jump.record.label, jump.states, jump.record.subject}},
      core::RunSerially));
  REQUIRE_OK(store.PutModel("d", built));
  REQUIRE_OK(store.PutExtension("d", extended, 0));
  for (int version = 3; version <= kKept + 3; ++version) {
    const auto put = store.PutModel("d", built);
    INFO(version << " " << put.status());
    REQUIRE(put.ok());
    // The first model is deleted together with the second, which extends it.
    REQUIRE(store.GetModel("d", 1).ok() == (version < kKept + 2));
    REQUIRE(store.GetModel("d", 2).ok() == (version < kKept + 2));
  }
  REQUIRE(Require(store.ListModels("d", 0, 2 * kKept)).size() == kKept);
}

TEST_CASE("SqliteMotionStore: keeps 1,000 finished operations", "[storage]") {
  constexpr int kKept = 1000;
  InMemory under_test;
  storage::MotionStore& store = under_test.Get();
  for (const char* const database : {"d", "other"}) {
    REQUIRE_OK(store.CreateDatabase(SampleDatabase(database)));
  }
  REQUIRE_OK(store.PutOperation(SampleOperation("other", "elsewhere")));
  const auto put = [&](const std::string& id, storage::OperationState last) {
    auto operation = SampleOperation("d", id);
    operation.state = storage::OperationState::kPending;
    REQUIRE_OK(store.PutOperation(operation));
    operation.state = last;
    REQUIRE_OK(store.PutOperation(operation));
  };
  put("waits", storage::OperationState::kRunning);
  put("ended", storage::OperationState::kSucceeded);
  for (int i = 0; i < kKept - 1; ++i) put(std::to_string(i), storage::OperationState::kCancelled);
  REQUIRE(store.GetOperation("ended").ok());
  put("one more", storage::OperationState::kFailed);
  REQUIRE_ERROR(store.GetOperation("ended"), StatusCode::kNotFound, "ended");
  for (const char* const kept : {"waits", "0", "one more", "elsewhere"}) {
    CAPTURE(kept);
    REQUIRE(store.GetOperation(kept).ok());
  }
}

}  // namespace motiondb::tests::sqlite_motion_store_test
