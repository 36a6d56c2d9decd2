// The data of deleted clips is removed from disk as soon as nothing needs it.
#include <sqlite3.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <thread>

#include "tests/support/test_engine.h"

namespace motiondb::tests::purge_test {
namespace {

using storage::OperationState;

// Returns the number that a query returns, also while an engine uses the store.
int Number(const TestEngine& engine, const std::string& sql) {
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open(engine.store_path().c_str(), &database) == SQLITE_OK);
  sqlite3_db_config(database, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  int number = -1;
  const auto keep = [](void* out, int, char** columns, char**) {
    *static_cast<int*>(out) = std::stoi(columns[0]);
    return 0;
  };
  const int code = sqlite3_exec(database, sql.c_str(), keep, &number, nullptr);
  sqlite3_close(database);
  REQUIRE(code == SQLITE_OK);
  return number;
}

int DeletedClips(const TestEngine& engine) {
  return Number(engine, "SELECT count(*) FROM clip WHERE deleted = 1");
}

// Builds a first model with the clip "a".
void FillWithModel(TestEngine& engine) {
  engine.Create("db");
  engine.Wait(engine.Ingest("db", "a", Walk(0))->operation.id);
  REQUIRE(engine.ModelVersion("db") == 1);
}

server::EngineOptions SlowOptions() {
  server::EngineOptions options = TestEngine::QuickOptions();
  options.rebuild_delay = std::chrono::hours(1);
  options.rebuild_delay_limit = std::chrono::hours(1);
  return options;
}

}  // namespace

TEST_CASE("Purge: a deleted clip that is in no model is removed", "[server][purge]") {
  TestEngine engine;
  FillWithModel(engine);
  engine.Stop();
  engine.set_options(SlowOptions());
  engine.Start();
  for (int i = 1; i < 4; ++i) {
    REQUIRE(engine.Ingest("db", "x", Walk(i)).ok());
    const auto deletion = engine->DeleteClip("db", "x");
    REQUIRE(deletion.ok());
    CHECK(DeletedClips(engine) == 0);
    // Also if no rebuild follows.
    CHECK(engine->CancelOperation(deletion->id)->operation.state == OperationState::kCancelled);
  }
  CHECK(engine.ModelVersion("db") == 1);
}

TEST_CASE("Purge: a deleted clip of the model stays until the next model", "[server][purge]") {
  TestEngine engine;
  FillWithModel(engine);
  engine.Wait(engine.Ingest("db", "b", Walk(1))->operation.id);
  REQUIRE(engine.ModelVersion("db") == 2);
  engine.gate().Close();
  const auto deletion = engine->DeleteClip("db", "b")->id;
  engine.gate().AwaitArrival();
  CHECK(DeletedClips(engine) == 1);
  engine.gate().Open();
  CHECK(engine.Wait(deletion).state == OperationState::kSucceeded);
  CHECK(engine.ModelVersion("db") == 3);
  CHECK(DeletedClips(engine) == 0);
}

TEST_CASE("Purge: a deleted clip that was kept for a build is removed when the build ends",
          "[server][purge]") {
  TestEngine engine;
  FillWithModel(engine);
  engine.gate().Close();
  const auto build = engine.Ingest("db", "x", Walk(1))->operation.id;
  engine.gate().AwaitArrival();  // it may have read the clip
  const auto next = engine->DeleteClip("db", "x")->id;
  CHECK(DeletedClips(engine) == 1);
  const bool is_cancelled = GENERATE(true, false);
  CAPTURE(is_cancelled);
  if (is_cancelled) {
    engine->CancelOperation(next).IgnoreError();
    engine->CancelOperation(build).IgnoreError();
  }
  engine.gate().Open();
  CHECK((engine.Wait(build).state == OperationState::kCancelled) == is_cancelled);
  if (!is_cancelled) engine.Wait(next);
  CHECK(DeletedClips(engine) == 0);
}

TEST_CASE("Purge: remains of a previous server are removed at start", "[server][purge]") {
  TestEngine engine;
  FillWithModel(engine);
  engine.Stop();
  engine.set_options(SlowOptions());
  engine.Start();
  REQUIRE(engine.Ingest("db", "x", Walk(1)).ok());
  engine.Stop();
  Number(engine, "UPDATE clip SET deleted = 1, skeleton_key = NULL WHERE id = 'x'");
  REQUIRE(DeletedClips(engine) == 1);
  engine.Start();
  CHECK(DeletedClips(engine) == 0);
  CHECK(engine.ModelVersion("db") == 1);
}

TEST_CASE("Purge: a deleted database is freed in the background, or by the next server",
          "[server][purge]") {
  TestEngine engine;
  FillWithModel(engine);
  const bool is_interrupted = GENERATE(true, false);
  CAPTURE(is_interrupted);
  if (is_interrupted) {
    engine.Stop();
    Number(engine, "UPDATE database SET deleted = 1, name = 'deleted/1'");
    engine.Start();
  } else {
    REQUIRE(engine->DeleteDatabase("db").ok());
  }
  CHECK(engine->Databases().empty());
  engine.Create("db");
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (Number(engine, "SELECT count(*) FROM database") > 1) {
    REQUIRE(std::chrono::steady_clock::now() < end);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  CHECK(Number(engine, "SELECT count(*) FROM clip_chunk") == 0);
  CHECK(Number(engine, "SELECT count(*) FROM model_chunk") == 0);
}

}  // namespace motiondb::tests::purge_test
