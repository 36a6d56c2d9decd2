// Server start: stored models and unfinished operations.
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "server/engine/snapshot.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::startup_test {
namespace {

using storage::OperationState;

// Waits until the newest operation of a database is done.
storage::OperationRecord WaitForNewest(TestEngine& engine, const std::string& database) {
  const auto newest = engine->operations().List(database, "", 1);
  REQUIRE(newest.ok());
  REQUIRE(newest->size() == 1);
  return engine.Wait(newest->front().id);
}

// Options of an engine whose builds wait until it is stopped.
server::EngineOptions WithoutBuilds() {
  auto options = TestEngine::QuickOptions();
  options.rebuild_delay = options.rebuild_delay_limit = std::chrono::hours(1);
  return options;
}

// Returns whether a database without clips is still open: an eviction notifies its listeners.
bool IsOpen(server::LiveDatabase& database) {
  std::atomic<bool> is_open = false;
  const auto subscription = database.signal()->Subscribe([&] { is_open = true; });
  database.lifecycle().Evict();
  return is_open;
}

// Drains the engine, in which `gate` blocks a build of the database `db`. The build continues when
// the drain has stopped it.
void DrainDuringBuild(TestEngine& engine) {
  // A drain stops the databases in the order of their names.
  const auto last = engine.Create("stopped-after-db");
  REQUIRE(IsOpen(*last));
  std::thread draining([&] { engine->Drain(); });
  while (IsOpen(*last)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  engine.gate().Open();
  draining.join();
}

TEST_CASE("Startup: reads the stored model and builds nothing", "[server][startup]") {
  TestEngine engine;
  engine.Create("db");
  engine.Wait(engine.Ingest("db", "a", Walk(0))->operation.id);
  const auto before = (*engine->FindDatabase("db"))->lifecycle().snapshot();
  engine.Stop();
  engine.gate().Close();  // a build would stop here
  engine.Start();
  const auto live = *engine->FindDatabase("db");
  const auto after = live->lifecycle().snapshot();
  REQUIRE(after != nullptr);
  CHECK(after->record.version == 1);
  CHECK(after->record.create_time_us == before->record.create_time_us);
  CHECK(after->model.build_seconds() == before->model.build_seconds());
  CHECK(after->model.states() == before->model.states());
  CHECK(after->model.tree().frame_order() == before->model.tree().frame_order());
  CHECK(live->stored().clip_count == 1);
  CHECK((*live->scheme())->set.markers == before->model.marker_set().markers);
  CHECK(engine->operations().List("db", "", 10)->size() == 1);
}

TEST_CASE("Startup: a read-only server serves the stored model and refuses changes",
          "[server][startup]") {
  TestEngine engine;
  engine.Create("db");
  engine.Wait(engine.Ingest("db", "a", Walk(0))->operation.id);
  REQUIRE(engine->store().PutOperation({.id = "waiting", .database = "db"}).ok());
  engine.Stop();
  auto opened = storage::SqliteMotionStore::Open(engine.store_path(), {.read_only = true});
  REQUIRE(opened.ok());
  auto started = server::Engine::Open(*std::move(opened), TestEngine::QuickOptions());
  REQUIRE(started.ok());
  server::Engine& read_only = **started;
  const auto live = *read_only.FindDatabase("db");
  REQUIRE(live->lifecycle().snapshot() != nullptr);
  CHECK(live->lifecycle().snapshot()->record.version == 1);
  CHECK(live->lifecycle().operation().empty());  // the waiting operation is not resumed
  CHECK(absl::IsFailedPrecondition(read_only.BeginIngest(live).status()));
  CHECK(absl::IsFailedPrecondition(read_only.DeleteClip("db", "a").status()));
  CHECK(absl::IsFailedPrecondition(read_only.CancelOperation("waiting").status()));
  CHECK(absl::IsFailedPrecondition(read_only.DeleteDatabase("db")));
  CHECK((*read_only.FindDatabase("db"))->lifecycle().snapshot() != nullptr);
  CHECK(read_only.corruptions().empty());
}

TEST_CASE("Startup: a waiting operation is resumed", "[server][startup]") {
  TestEngine engine(WithoutBuilds());
  engine.Create("db");
  const auto waiting = engine.Ingest("db", "a", Walk(0))->operation.id;
  engine.Stop();
  engine.Start();
  CHECK(engine->operations().Get(waiting)->state == OperationState::kPending);
  engine.Stop();
  engine.set_options(TestEngine::QuickOptions());
  engine.Start();
  const auto operation = engine.Wait(waiting);
  CHECK(operation.state == OperationState::kSucceeded);
  CHECK(operation.model_version == 1);
}

TEST_CASE("Startup: a build stopped by the drain is PENDING and resumed", "[server][startup]") {
  TestEngine engine;
  engine.Create("db");
  engine.gate().Close();
  const auto running = engine.Ingest("db", "a", Walk(0))->operation.id;
  engine.gate().AwaitArrival();
  DrainDuringBuild(engine);
  CHECK(engine->operations().Get(running)->state == OperationState::kPending);
  engine.Stop();
  engine.Start();
  CHECK(engine.Wait(running).state == OperationState::kSucceeded);
  CHECK(engine.ModelVersion("db") == 1);
}

TEST_CASE("Startup: a cancelled operation is not resumed, but its clips are built",
          "[server][startup]") {
  TestEngine engine;
  engine.Create("db");
  const auto cancelled = engine.Ingest("db", "a", Walk(0))->operation.id;
  REQUIRE(engine->CancelOperation(cancelled)->operation.state == OperationState::kCancelled);
  engine.Stop();
  engine.Start();
  CHECK(WaitForNewest(engine, "db").state == OperationState::kSucceeded);
  CHECK(engine->operations().Get(cancelled)->state == OperationState::kCancelled);
  CHECK(engine.ModelVersion("db") == 1);
}

TEST_CASE("Startup: an unreadable model is rebuilt", "[server][startup]") {
  TestEngine engine;
  engine.Create("db");
  engine.Wait(engine.Ingest("db", "a", Walk(0))->operation.id);
  engine.Stop();
  engine.Start(absl::DataLossError("chunk 3 is corrupt"));
  CHECK(WaitForNewest(engine, "db").model_version == 2);
  CHECK(engine.ModelVersion("db") == 2);
}

TEST_CASE("Startup: with a full disk, stored models are served and rebuilt when there is space",
          "[server][startup]") {
  TestEngine engine;
  engine.Create("db");
  engine.Wait(engine.Ingest("db", "a", Walk(0))->operation.id);
  engine.Stop();
  engine.set_options(WithoutBuilds());
  engine.Start();
  const auto last_operation = engine.Ingest("db", "b", Walk(1))->operation.id;
  const bool is_resumed = GENERATE(true, false);
  CAPTURE(is_resumed);
  // Otherwise the rebuild is requested because the model lacks clips.
  if (!is_resumed)
    REQUIRE(engine->CancelOperation(last_operation)->operation.state == OperationState::kCancelled);
  engine.Stop();

  auto options = TestEngine::QuickOptions();
  options.rebuild_delay = std::chrono::milliseconds(500);
  engine.set_options(options);
  engine.disk().Set(SimulatedDisk::Lacks::kRoom);
  engine.Start();
  const auto live = *engine->FindDatabase("db");
  const auto model = engine->CurrentModel(*live);
  REQUIRE(model.ok());
  CHECK((*model)->record.version == 1);
  const auto operation = engine->CurrentOperation(*live);
  REQUIRE(operation.has_value());
  CHECK((operation->id == last_operation) == is_resumed);
  CHECK(engine.Wait(operation->id).error_code ==
        static_cast<int>(absl::StatusCode::kResourceExhausted));
  CHECK(engine.ModelVersion("db") == 1);

  engine.disk().Set(SimulatedDisk::Lacks::kNothing);
  engine.Wait(engine.Ingest("db", "c", Walk(2))->operation.id);
  CHECK((*engine->FindDatabase("db"))->lifecycle().snapshot()->model.clips().size() == 3);
}

TEST_CASE("Startup: two unfinished operations both end, with one model", "[server][startup]") {
  TestEngine engine;
  engine.Create("db");
  engine.gate().Close();
  const auto first = engine.Ingest("db", "a", Walk(0))->operation.id;
  engine.gate().AwaitArrival();
  const auto second = engine.Ingest("db", "b", Walk(1))->operation.id;
  DrainDuringBuild(engine);
  REQUIRE(engine->operations().Get(first)->state == OperationState::kPending);
  engine.Stop();
  engine.Start();
  CHECK(engine.Wait(first).model_version == 1);
  CHECK(engine.Wait(second).model_version == 1);
}

}  // namespace
}  // namespace motiondb::tests::startup_test
