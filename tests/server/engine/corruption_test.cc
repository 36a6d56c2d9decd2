// A corrupt blob affects only its owner and is reported; everything else is built and served.
#include <catch2/catch.hpp>
#include <fstream>
#include <string>
#include <vector>

#include "server/engine/snapshot.h"
#include "tests/storage/faults/corrupt_store.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::corruption_test {
namespace {

using storage::OperationState;

// Stores clips a, b and c with a model, then stops the engine.
void Fill(TestEngine& engine) {
  engine.Create("db");
  engine.Ingest("db", "a", Walk(0)).value();
  engine.Ingest("db", "b", Walk(1)).value();
  engine.Wait(engine.Ingest("db", "c", Walk(2))->operation.id);
  engine.Stop();
}

std::string Sql(const TestEngine& engine, const std::string& script) {
  return RunSql(engine.store_path(), script);
}

// Waits for all operations.
void Settle(TestEngine& engine) {
  const auto operations = engine->operations().List("db", "", 100);
  REQUIRE(operations.ok());
  for (const auto& operation : *operations) engine.Wait(operation.id);
}

std::string ClipsOfModel(TestEngine& engine) {
  const auto snapshot = (*engine->FindDatabase("db"))->lifecycle().snapshot();
  if (snapshot == nullptr) return "none";
  std::string ids;
  for (const auto& clip : snapshot->model.clips()) ids += clip.id;
  return ids;
}

std::string CorruptResources(TestEngine& engine) {
  std::string resources;
  for (const auto& corruption : engine->corruptions()) resources += corruption.resource + " ";
  return resources;
}

}  // namespace

TEST_CASE("Corruption: a corrupt clip is left out and reported, at start and later",
          "[server][corruption]") {
  TestEngine engine;
  Fill(engine);
  Sql(engine, ChangeByte("clip_chunk", 100, ChunksOf("b", 3)));
  engine.Start();
  Settle(engine);
  CHECK(ClipsOfModel(engine) == "ac");
  CHECK_THAT(CorruptResources(engine), Catch::Contains("databases/db/clips/b "));
  const int version = engine.ModelVersion("db");
  const auto operations = engine->operations().List("db", "", 100)->size();
  engine.Stop();

  // The model lacks only the corrupt clip: it is not built again.
  engine.Start();
  CHECK(engine.ModelVersion("db") == version);
  CHECK(engine->operations().List("db", "", 100)->size() == operations);
  CHECK(CorruptResources(engine) == "databases/db/clips/b ");

  // Other clips can be added and deleted.
  engine.Wait(engine.Ingest("db", "d", Walk(3))->operation.id);
  CHECK(ClipsOfModel(engine) == "acd");
  engine.Wait(engine->DeleteClip("db", "b")->id);
  CHECK(CorruptResources(engine).empty());
  engine.Wait(engine.Ingest("db", "b", Walk(1))->operation.id);
  CHECK(ClipsOfModel(engine) == "abcd");
}

TEST_CASE("Corruption: a clip that becomes readable is used again", "[server][corruption]") {
  TestEngine engine;
  Fill(engine);
  Sql(engine, "UPDATE clip_chunk SET kind = 103 WHERE " + ChunksOf("b", 3));
  engine.Start();
  Settle(engine);
  CHECK(ClipsOfModel(engine) == "ac");
  CHECK_THAT(CorruptResources(engine), Catch::Contains("databases/db/clips/b "));
  // As if the disk had recovered.
  Sql(engine, "UPDATE clip_chunk SET kind = 3 WHERE " + ChunksOf("b", 103));
  engine.Wait(engine->DeleteClip("db", "c")->id);
  CHECK(ClipsOfModel(engine) == "ab");
  CHECK(CorruptResources(engine).find("databases/db/clips/b ") == std::string::npos);
}

TEST_CASE("Corruption: an extension leaves a corrupt clip out", "[server][corruption]") {
  auto options = TestEngine::QuickOptions();
  options.extend_from = std::chrono::seconds(0);
  TestEngine engine(options);
  Fill(engine);
  Sql(engine, "DELETE FROM model_clip WHERE clip_key = (SELECT clip_key FROM clip WHERE id = 'c')");
  Sql(engine, ChangeByte("clip_chunk", 100, ChunksOf("b", 3)));
  engine.Start();
  Settle(engine);
  CHECK(ClipsOfModel(engine) == "ac");
}

TEST_CASE("Corruption: a corrupt model is rebuilt from the clips", "[server][corruption]") {
  TestEngine engine;
  Fill(engine);
  Sql(engine, ChangeByte("model_chunk", 100, "position = 0"));
  engine.Start();
  Settle(engine);
  CHECK(ClipsOfModel(engine) == "abc");
  CHECK_THAT(CorruptResources(engine), Catch::Contains("databases/db/models/"));
}

TEST_CASE("Corruption: a model is served although the list of its clips is corrupt",
          "[server][corruption]") {
  TestEngine engine;
  Fill(engine);
  CorruptPage(engine.store_path(), std::stol(Sql(engine, RootPageOf("clip_of_database"))));
  engine.Start();
  CHECK(ClipsOfModel(engine) == "abc");
  CHECK_THAT(CorruptResources(engine), Catch::Contains("databases/db "));
}

TEST_CASE("Corruption: a database is served although its operations are corrupt",
          "[server][corruption]") {
  TestEngine engine;
  Fill(engine);
  const int page = std::stoi(
      Sql(engine,
          "PRAGMA wal_checkpoint(TRUNCATE); SELECT rootpage FROM sqlite_schema WHERE name = "
          "'operation'"));
  const int page_bytes = std::stoi(Sql(engine, "PRAGMA page_size"));
  {
    std::fstream file(engine.store_path(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(page - 1) * page_bytes);
    file << std::string(512, '\0');
  }
  engine.Start();
  CHECK(ClipsOfModel(engine) == "abc");
  REQUIRE(engine->corruptions().size() == 1);
  CHECK_THAT(engine->corruptions().front().description, Catch::StartsWith("operations: "));
}

TEST_CASE("Corruption: a corrupt source or skeleton does not affect the model",
          "[server][corruption]") {
  TestEngine engine;
  Fill(engine);
  Sql(engine, ChangeByte("clip_chunk", 26, ChunksOf("b", 1)));
  Sql(engine, ChangeByte("skeleton_chunk", 60, "1"));
  engine.Start();
  CHECK(ClipsOfModel(engine) == "abc");
  CHECK(CorruptResources(engine).empty());  // not read yet
  engine.Wait(engine.Ingest("db", "d", Walk(3))->operation.id);
  CHECK(ClipsOfModel(engine) == "abcd");
}

TEST_CASE("Corruption: the build of a database without a readable clip fails",
          "[server][corruption]") {
  TestEngine engine;
  Fill(engine);
  Sql(engine, ChangeByte("clip_chunk", 100, "kind = 3"));
  engine.Start();
  Settle(engine);
  CHECK(ClipsOfModel(engine) == "none");
  const auto newest = engine->operations().List("db", "", 1)->front();
  CHECK(newest.state == OperationState::kFailed);
  CHECK_THAT(newest.error_message, Catch::Contains("all are corrupt"));
  engine.Wait(engine.Ingest("db", "d", Walk(3))->operation.id);
  CHECK(ClipsOfModel(engine) == "d");
}

}  // namespace motiondb::tests::corruption_test
