// What interrupts a build: a slow or full disk, a cancellation, a deletion.
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "server/engine/snapshot.h"
#include "tests/support/slow_store.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::build_interruption_test {
namespace {

using storage::OperationState;

// An engine whose store can block while it stores an operation.
class SlowEngine {
 public:
  explicit SlowEngine(const server::EngineOptions& options = TestEngine::QuickOptions())
      : engine_(*server::Engine::Open(std::make_unique<SlowStore>(disk_), options)) {}
  server::Engine* operator->() { return engine_.get(); }
  Gate& disk() { return *disk_; }
  std::shared_ptr<server::LiveDatabase> Create(const std::string& name) {
    const core::BuildSettings settings{.frame_rate_hz = 60, .min_frames = 4};
    CHECK(engine_->CreateDatabase(name, settings, {server::kSourceMarkerSet, ""}).ok());
    return *engine_->FindDatabase(name);
  }
  absl::StatusOr<server::Ingested> Ingest(const std::string& database,
                                          const core::Cancelled& cancelled = {}) {
    storage::NewClip clip;
    clip.record.file_name = "walk.bvh";
    clip.file_bytes = WriteBvh(Walk(0));
    return engine_->Ingest(*engine_->FindDatabase(database), {std::move(clip)},
                           {.cancelled = cancelled});
  }

 private:
  const std::shared_ptr<Gate> disk_ = std::make_shared<Gate>();
  const std::unique_ptr<server::Engine> engine_;
};

TEST_CASE("Lifecycle: storing an operation does not block ingests", "[server][lifecycle]") {
  SlowEngine engine;
  const auto slow = engine.Create("slow");
  const auto other = engine.Create("other");
  const auto check_others_continue = [&] {
    engine.disk().AwaitArrival();
    CHECK(engine->BeginIngest(other).ok());
    CHECK(engine->BeginIngest(slow).ok());
    engine.disk().Open();
  };
  auto waiting = *engine->BeginIngest(slow);
  engine.disk().Close();
  absl::StatusOr<server::Ingested> ingested;
  std::thread ingesting([&] { ingested = engine.Ingest("slow"); });
  check_others_continue();  // while it is created
  ingesting.join();
  REQUIRE(ingested.ok());
  engine.disk().Close();
  waiting.reset();
  check_others_continue();  // while it starts
  CHECK(engine->operations().Get(ingested->operation.id).ok());
}

TEST_CASE("Lifecycle: a rebuild happens although its request was cancelled",
          "[server][lifecycle]") {
  SlowEngine engine;
  engine.Create("db");
  engine.disk().Close();
  std::atomic<bool> is_late = false;
  absl::StatusOr<server::Ingested> ingested;
  std::thread ingesting([&] { ingested = engine.Ingest("db", [&] { return is_late.load(); }); });
  engine.disk().AwaitArrival();
  is_late = true;
  engine.disk().Open();
  ingesting.join();
  CHECK(absl::IsCancelled(ingested.status()));
  CHECK(engine->store().GetClip("db", "walk").ok());
  const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while ((*engine->FindDatabase("db"))->lifecycle().snapshot() == nullptr) {
    REQUIRE(std::chrono::steady_clock::now() < limit);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  CHECK(engine->operations().List("db", "", 10)->size() == 1);
}

TEST_CASE("Lifecycle: a build of a deleted database does not affect a new one of the same name",
          "[server][lifecycle]") {
  SlowEngine engine;
  auto waiting = *engine->BeginIngest(engine.Create("db"));
  const auto ingested = engine.Ingest("db");
  REQUIRE(ingested.ok());
  std::promise<void> over;
  const auto watch =
      engine->operations().Watch(ingested->operation.id, [&](const auto&) { over.set_value(); });
  engine.disk().Close();
  waiting.reset();
  engine.disk().AwaitArrival();
  std::thread replacing([&] {
    CHECK(engine->DeleteDatabase("db").ok());
    engine.Create("db");
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  engine.disk().Open();
  replacing.join();
  if (watch != 0) over.get_future().wait();
  CHECK(engine->operations().List("db", "", 10)->empty());
}

TEST_CASE("Lifecycle: a build that ran out of disk space is retried until it succeeds",
          "[server][lifecycle]") {
  auto options = TestEngine::QuickOptions();
  options.rebuild_retry_delay = std::chrono::milliseconds(100);
  TestEngine engine(options);
  engine.Create("db");
  engine.gate().Close();
  const auto ingested = engine.Ingest("db", "walk", Walk(0));
  REQUIRE(ingested.ok());
  engine.gate().AwaitArrival();
  engine.disk().Set(SimulatedDisk::Lacks::kRoom);
  engine.gate().Open();
  CHECK(engine.Wait(ingested->operation.id).state == OperationState::kFailed);
  CHECK(engine.ModelVersion("db") == 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // one or two retries fail
  CHECK(engine.ModelVersion("db") == 0);
  engine.disk().Set(SimulatedDisk::Lacks::kNothing);
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (engine.ModelVersion("db") == 0 && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  CHECK(engine.ModelVersion("db") == 1);
}

TEST_CASE("Lifecycle: a retry ends with its database and with the server", "[server][lifecycle]") {
  auto options = TestEngine::QuickOptions();
  options.rebuild_retry_delay = std::chrono::milliseconds(50);
  TestEngine engine(options);
  const auto fail = [&](const std::string& id) {
    engine.Create(id);
    engine.gate().Close();
    const auto ingested = engine.Ingest(id, "walk", Walk(0));
    REQUIRE(ingested.ok());
    engine.gate().AwaitArrival();
    engine.disk().Set(SimulatedDisk::Lacks::kRoom);
    engine.gate().Open();
    CHECK(engine.Wait(ingested->operation.id).state == OperationState::kFailed);
    engine.disk().Set(SimulatedDisk::Lacks::kNothing);
  };
  fail("deleted");
  CHECK(engine->DeleteDatabase("deleted").ok());
  engine.Create("deleted");
  fail("db");
  engine.Stop();
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  engine.Start();
  CHECK(engine.ModelVersion("deleted") == 0);
}

TEST_CASE("Lifecycle: a new model continues to answer if it cannot be stored",
          "[server][lifecycle]") {
  auto options = TestEngine::QuickOptions();
  options.rebuild_retry_delay = std::chrono::milliseconds(100);
  TestEngine engine(options);
  const auto live = engine.Create("db");
  engine.model_gate().Close();
  const auto ingested = engine.Ingest("db", "walk", Walk(0));
  REQUIRE(ingested.ok());
  engine.model_gate().AwaitArrival();
  engine.disk().Set(SimulatedDisk::Lacks::kRoom);
  engine.model_gate().Open();
  CHECK(engine.Wait(ingested->operation.id).state == OperationState::kFailed);
  const auto snapshot = live->lifecycle().snapshot();
  REQUIRE(snapshot != nullptr);
  CHECK_FALSE(snapshot->is_stored());
  CHECK(snapshot->model.clips().size() == 1);
  engine.disk().Set(SimulatedDisk::Lacks::kNothing);
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (engine.ModelVersion("db") == 0 && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  CHECK(engine.ModelVersion("db") == 1);
  CHECK(live->lifecycle().snapshot()->is_stored());
}

TEST_CASE("Lifecycle: a cancellation that is itself cancelled changes nothing",
          "[server][lifecycle]") {
  auto options = TestEngine::QuickOptions();
  options.rebuild_delay = options.rebuild_delay_limit = std::chrono::hours(1);
  TestEngine engine(options);
  engine.Create("db");
  const auto ingested = engine.Ingest("db", "walk", Walk(0));
  REQUIRE(ingested.ok());
  const std::string id = ingested->operation.id;
  for (const int attempt : {1, 2}) {
    INFO(attempt);
    const core::Cancelled late = [] { return true; };
    CHECK(absl::IsCancelled(engine->CancelOperation(id, late).status()));
    CHECK(engine->operations().Get(id)->state == OperationState::kPending);
    CHECK((*engine->FindDatabase("db"))->lifecycle().operation() == id);
    CHECK(engine.Ingest("db", "walk", Walk(attempt))->operation.id == id);
  }
  const auto cancellation = engine->CancelOperation(id);
  REQUIRE(cancellation.ok());
  CHECK(cancellation->is_first);
  CHECK(engine->store().GetOperation(id)->state == OperationState::kCancelled);
}

TEST_CASE("Lifecycle: a waiting operation is cancelled immediately, a running one soon",
          "[server][lifecycle]") {
  TestEngine engine;
  engine.Create("db");
  engine.gate().Close();
  const auto running = engine.Ingest("db", "a", Walk(0))->operation.id;
  engine.gate().AwaitArrival();
  const auto waiting = engine.Ingest("db", "b", Walk(1))->operation.id;
  const auto first = engine->CancelOperation(waiting);
  CHECK(first->operation.state == OperationState::kCancelled);
  CHECK(first->is_first);
  CHECK(!engine->CancelOperation(waiting)->is_first);
  const auto soon = engine->CancelOperation(running);
  CHECK(soon->operation.state == OperationState::kRunning);
  CHECK(soon->is_first);
  CHECK(!engine->CancelOperation(running)->is_first);
  engine.gate().Open();
  CHECK(engine.Wait(running).state == OperationState::kCancelled);
  CHECK(engine.ModelVersion("db") == 0);
  CHECK(engine->CancelOperation(running)->operation.state == OperationState::kCancelled);
  CHECK(absl::IsNotFound(engine->CancelOperation("x").status()));

  // The clips stay: the next change builds a model of all clips.
  const auto next = engine.Ingest("db", "c", Walk(2));
  CHECK(engine.Wait(next->operation.id).state == OperationState::kSucceeded);
  CHECK((*engine->FindDatabase("db"))->lifecycle().snapshot()->model.clips().size() == 3);
}

TEST_CASE("Lifecycle: a clip deleted during the build is not in the model", "[server][lifecycle]") {
  TestEngine engine;
  const auto live = engine.Create("db");
  engine.gate().Close();
  REQUIRE(engine.Ingest("db", "a", Walk(0)).ok());
  const auto build = engine.Ingest("db", "b", Walk(1))->operation.id;
  engine.gate().AwaitArrival();
  const auto deletion = engine->DeleteClip("db", "b");
  REQUIRE(deletion.ok());
  engine.gate().Open();
  CHECK(engine.Wait(build).state == OperationState::kSucceeded);
  CHECK(engine.Wait(deletion->id).state == OperationState::kSucceeded);
  REQUIRE(live->lifecycle().snapshot()->model.clips().size() == 1);
  CHECK(live->lifecycle().snapshot()->model.clips()[0].id == "a");
}

TEST_CASE("Lifecycle: deleting a database ends its operations and builds", "[server][lifecycle]") {
  TestEngine engine;
  const auto live = engine.Create("db");
  engine.gate().Close();
  const auto running = engine.Ingest("db", "a", Walk(0))->operation.id;
  engine.gate().AwaitArrival();
  REQUIRE(engine.Ingest("db", "b", Walk(1)).ok());
  REQUIRE(engine->DeleteDatabase("db").ok());
  CHECK(absl::IsNotFound(engine->FindDatabase("db").status()));
  CHECK(absl::IsNotFound(engine->DeleteDatabase("db")));

  // A new database of the same name is empty, whatever the old build does.
  engine.Create("db");
  engine.gate().Open();
  const auto fresh = engine.Ingest("db", "c", Walk(2));
  REQUIRE(fresh.ok());
  CHECK(engine.Wait(fresh->operation.id).model_version == 1);
  CHECK((*engine->FindDatabase("db"))->lifecycle().snapshot()->model.clips().size() == 1);
  CHECK(live->lifecycle().snapshot() == nullptr);
  CHECK(absl::IsNotFound(engine->operations().Get(running).status()));
}

}  // namespace
}  // namespace motiondb::tests::build_interruption_test
