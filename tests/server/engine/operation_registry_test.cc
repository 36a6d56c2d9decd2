#include "server/engine/work/operation_registry.h"

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <sstream>

#include "core/model/model.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/support/gated_store.h"

namespace motiondb::server::operation_registry_test {
namespace {

using storage::OperationState;

class RegistryFixture {
 public:
  RegistryFixture()
      : store_(std::make_unique<tests::GatedStore>(*storage::SqliteMotionStore::Open(":memory:"),
                                                   std::make_shared<tests::Gate>(),
                                                   std::make_shared<tests::Gate>(), disk_)),
        registry_(*store_) {
    REQUIRE(store_->CreateDatabase({.name = "db", .marker_set = "source"}).ok());
  }
  OperationRegistry* operator->() { return &registry_; }
  storage::MotionStore& store() { return *store_; }
  tests::SimulatedDisk& disk() { return *disk_; }

 private:
  const std::shared_ptr<tests::SimulatedDisk> disk_ = std::make_shared<tests::SimulatedDisk>();
  std::unique_ptr<storage::MotionStore> store_;
  OperationRegistry registry_;
};

TEST_CASE("OperationRegistry: states are stored, progress is not", "[server]") {
  RegistryFixture registry;
  const std::string id = registry->Create("db")->id;
  CHECK(registry.store().GetOperation(id)->state == OperationState::kPending);
  registry->Start(id);
  registry->Advance(id, 0.5, "tree, layer 7");
  CHECK(registry->Get(id)->progress == 0.5);
  CHECK(registry->Get(id)->stage == "tree, layer 7");
  CHECK(registry.store().GetOperation(id)->state == OperationState::kRunning);
  CHECK(registry.store().GetOperation(id)->progress == 0);
  CHECK(registry->List("db", "", 10)->front().progress == 0.5);
  CHECK(registry->Succeed(id, 3).ok());
  CHECK(registry.store().GetOperation(id)->state == OperationState::kSucceeded);
  CHECK(registry->Get(id)->model_version == 3);
  CHECK(registry->Get(id)->progress == 1);
}

TEST_CASE("OperationRegistry: a failure keeps its code and message", "[server]") {
  RegistryFixture registry;
  const std::string id = registry->Create("db")->id;
  CHECK(registry->Fail(id, absl::DataLossError("clip 'a' is corrupt")).ok());
  const auto record = *registry->Get(id);
  CHECK(record.state == OperationState::kFailed);
  CHECK(record.error_code == static_cast<int>(absl::StatusCode::kDataLoss));
  CHECK(record.error_message == "clip 'a' is corrupt");
}

TEST_CASE("OperationRegistry: a finished operation does not change", "[server]") {
  RegistryFixture registry;
  const std::string id = registry->Create("db")->id;
  CHECK(registry->Cancel(id).ok());
  CHECK(registry->Succeed(id, 1).ok());
  CHECK(registry->Get(id)->state == OperationState::kCancelled);
}

TEST_CASE("OperationRegistry: a watcher is called once, at the end", "[server]") {
  RegistryFixture registry;
  const std::string id = registry->Create("db")->id;
  int calls = 0;
  OperationState seen = OperationState::kPending;
  const auto watcher = [&](const storage::OperationRecord& record) {
    ++calls;
    seen = record.state;
  };
  CHECK(registry->Watch(id, watcher) != 0);
  const auto unwatched = registry->Watch(id, [](const auto&) { FAIL("called after Unwatch"); });
  registry->Unwatch(id, unwatched);
  registry->Start(id);
  registry->Advance(id, 0.1, "reading");
  CHECK(calls == 0);
  CHECK(registry->Succeed(id, 1).ok());
  CHECK(calls == 1);
  CHECK(seen == OperationState::kSucceeded);
  CHECK(registry->Watch(id, watcher) == 0);
  CHECK(registry->Watch("no-such-operation", watcher) == 0);
}

TEST_CASE("OperationRegistry: a stopping server ends all waits", "[server]") {
  RegistryFixture registry;
  const std::string id = registry->Create("db")->id;
  int calls = 0;
  registry->Watch(id, [&](const auto&) { ++calls; });
  registry->EndWaits();
  CHECK(calls == 1);
  CHECK(registry->Watch(id, [&](const auto&) { ++calls; }) == 0);
}

TEST_CASE("OperationRegistry: ids are unique and the newest comes first", "[server]") {
  RegistryFixture registry;
  std::set<std::string> ids;
  std::string last;
  for (int i = 0; i < 50; ++i) ids.insert(last = registry->Create("db")->id);
  CHECK(ids.size() == 50);
  CHECK(registry->List("db", "", 1)->front().id == last);
  CHECK(registry->List("", "", 100)->size() == 50);
  CHECK(absl::IsNotFound(registry->Get("x").status()));
  CHECK(absl::IsNotFound(registry->Create("no-such-database").status()));
}

// Captures the server's log during its lifetime.
class Log {
 public:
  Log() {
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "test", std::make_shared<spdlog::sinks::ostream_sink_st>(text_)));
  }
  ~Log() { spdlog::set_default_logger(previous_); }
  int line_count() const {
    const std::string text = text_.str();
    return static_cast<int>(std::ranges::count(text, '\n'));
  }

 private:
  std::ostringstream text_;
  const std::shared_ptr<spdlog::logger> previous_ = spdlog::default_logger();
};

TEST_CASE("OperationRegistry: an operation that cannot be stored is kept in memory and logged once",
          "[server]") {
  const Log log;
  RegistryFixture registry;
  registry.disk().Set(tests::SimulatedDisk::Lacks::kRoomForOperations);
  const auto created = registry->Create("db");
  INFO(created.status().ToString());
  REQUIRE(created.ok());
  CHECK(log.line_count() == 1);
  CHECK(registry->Get(created->id)->state == OperationState::kPending);
  CHECK(absl::IsNotFound(registry.store().GetOperation(created->id).status()));
  int called = 0;
  CHECK(registry->Watch(created->id, [&](const storage::OperationRecord&) { ++called; }) != 0);
  registry->Start(created->id);
  CHECK(registry->Get(created->id)->state == OperationState::kRunning);

  SECTION("the disk has space before it ends") {
    registry.disk().Set(tests::SimulatedDisk::Lacks::kNothing);
    CHECK(registry->Succeed(created->id, 2).ok());
    CHECK(registry.store().GetOperation(created->id)->state == OperationState::kSucceeded);
  }
  SECTION("the disk stays full to the end") {
    CHECK(registry->Succeed(created->id, 2).ok());
    CHECK(absl::IsNotFound(registry.store().GetOperation(created->id).status()));
  }
  CHECK(called == 1);
  CHECK(registry->Get(created->id)->state == OperationState::kSucceeded);
  CHECK(registry->Get(created->id)->model_version == 2);
  CHECK(log.line_count() == 1);
}

TEST_CASE("OperationRegistry: a cancelled call changes nothing", "[server]") {
  const Log log;
  const core::Cancelled immediately = [] { return true; };
  RegistryFixture registry;
  CHECK(absl::IsCancelled(registry->Create("db", immediately).status()));
  CHECK(registry->List("db", "", 10)->empty());
  const std::string id = registry->Create("db")->id;
  int called = 0;
  registry->Watch(id, [&](const storage::OperationRecord&) { ++called; });
  CHECK(absl::IsCancelled(registry->Cancel(id, immediately)));
  CHECK(registry->Get(id)->state == OperationState::kPending);
  CHECK(called == 0);
  CHECK(registry->Cancel(id).ok());
  CHECK(registry->Get(id)->state == OperationState::kCancelled);
  CHECK(called == 1);
  CHECK(log.line_count() == 0);
}

TEST_CASE("OperationRegistry: operations of a deleted database end without an error", "[server]") {
  const Log log;
  RegistryFixture registry;
  const std::string building = registry->Create("db")->id;
  const std::string waiting = registry->Create("db")->id;
  int called = 0;
  registry->Watch(building, [&](const storage::OperationRecord&) { ++called; });
  REQUIRE(registry.store().DeleteDatabase("db").ok());
  registry->Start(building);
  CHECK(registry->Succeed(building, 1).ok());
  CHECK(registry->Cancel(waiting).ok());
  CHECK(called == 1);
  CHECK(absl::IsNotFound(registry->Get(building).status()));
  CHECK(absl::IsNotFound(registry->Get(waiting).status()));
  CHECK(log.line_count() == 0);
}

// The registries of two servers on one store.
struct TwoRegistries {
  TwoRegistries() { REQUIRE(store.CreateDatabase({.name = "db", .marker_set = "source"}).ok()); }
  void Follow(OperationRegistry& registry) { registry.Follow(*store.ListUnfinishedOperations()); }

  tests::SharedStore store{*storage::SqliteMotionStore::Open(":memory:"),
                           std::make_shared<tests::Gate>()};
  OperationRegistry a{store};
  OperationRegistry b{store};
};

TEST_CASE("OperationRegistry: the first result in a shared store counts", "[server]") {
  TwoRegistries registries;
  auto& [store, a, b] = registries;
  const std::string id = a.Create("db")->id;
  registries.Follow(b);
  OperationState seen = OperationState::kPending;
  const auto watcher = [&](const storage::OperationRecord& record) { seen = record.state; };
  CHECK(a.Start(id));
  REQUIRE(a.Watch(id, watcher) != 0);
  SECTION("cancelled") {
    CHECK(*b.CancelAnywhere(id));
    CHECK(a.Succeed(id, 3).ok());
    CHECK(seen == OperationState::kCancelled);
    CHECK(a.Get(id)->state == OperationState::kCancelled);
    CHECK(b.Get(id)->state == OperationState::kCancelled);
  }
  SECTION("built twice") {
    CHECK(b.Start(id));
    CHECK(b.Succeed(id, 3).ok());
    CHECK(a.Succeed(id, 4).ok());
    CHECK(seen == OperationState::kSucceeded);
    CHECK(a.Get(id)->model_version == 3);
    CHECK(b.Get(id)->model_version == 3);
  }
}

TEST_CASE("OperationRegistry: a server that drops a former database ends no operation of the new",
          "[server]") {
  TwoRegistries registries;
  auto& [store, a, b] = registries;
  const std::string former = a.Create("db")->id;
  registries.Follow(b);
  REQUIRE(store.DeleteDatabase("db").ok());
  REQUIRE(store.CreateDatabase({.name = "db", .marker_set = "source"}).ok());
  const std::string id = a.Create("db")->id;
  registries.Follow(b);
  CHECK(b.Start(id));
  OperationState seen = OperationState::kPending;
  REQUIRE(b.Watch(id, [&](const storage::OperationRecord& record) { seen = record.state; }) != 0);
  // It knows both only by their name.
  CHECK_FALSE(b.Start(former));
  b.Abandon(id);
  CHECK(seen == OperationState::kPending);
  registries.Follow(b);
  CHECK(a.Start(id));
  CHECK(a.Succeed(id, 1).ok());
  registries.Follow(b);
  CHECK(seen == OperationState::kSucceeded);
  CHECK(a.List("db", "", 10)->size() == 1);
}

}  // namespace
}  // namespace motiondb::server::operation_registry_test
