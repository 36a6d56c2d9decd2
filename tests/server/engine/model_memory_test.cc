// Models are read when they are used, and evicted (EngineOptions::model_memory_bytes).
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "server/engine/query/query.h"
#include "server/engine/work/work_options.h"
#include "tests/storage/faults/corrupt_store.h"
#include "tests/storage/require_ok.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::model_memory_test {
namespace {

// Memory for all models; or for one only, because the last used model always stays.
constexpr std::int64_t kAll = std::int64_t{1} << 40;
constexpr std::int64_t kOne = 1;

server::EngineOptions WithMemory(std::int64_t bytes) {
  auto options = TestEngine::QuickOptions();
  options.model_memory_bytes = bytes;
  return options;
}

// Stores databases with models of one clip.
void Fill(TestEngine& engine, const std::vector<std::string>& databases) {
  for (const std::string& name : databases) {
    engine.Create(name);
    engine.Wait(Require(engine.Ingest(name, "walk", Walk(0))).operation.id);
  }
}

bool IsInMemory(TestEngine& engine, const std::string& name) {
  return Require(engine->FindDatabase(name))->lifecycle().model_bytes() > 0;
}

// Calls `begin` as a call of a client: again after each change of the database that it waits for.
template <typename Begin>
auto Call(const Begin& begin) {
  std::atomic<int> changes = 0;
  std::vector<std::unique_ptr<server::ChangeSignal::Subscription>> subscriptions;
  server::WorkOptions terms;
  terms.wake_on = [&](server::ChangeSignal& signal) {
    subscriptions.push_back(signal.Subscribe([&] { ++changes; }));
  };
  const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (true) {
    const int seen = changes;
    auto result = begin(terms);
    if (!server::IsAwaitingChange(result.status())) return result;
    while (changes == seen) {
      REQUIRE(std::chrono::steady_clock::now() < latest);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
}

absl::StatusOr<server::SnapshotPointer> Model(TestEngine& engine, const std::string& name) {
  const auto live = Require(engine->FindDatabase(name));
  return Call([&](const server::WorkOptions& terms) { return engine->CurrentModel(*live, terms); });
}

// Evictions follow a use, on another thread.
void AwaitInMemory(TestEngine& engine, const std::string& name, bool expected) {
  const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (IsInMemory(engine, name) != expected) {
    REQUIRE(std::chrono::steady_clock::now() < latest);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace

TEST_CASE("Model memory: a model is read when it is first used", "[server][memory]") {
  TestEngine engine;
  Fill(engine, {"a", "b"});
  const auto stored = Require(Model(engine, "a"));
  engine.Stop();
  engine.set_options(WithMemory(kAll));
  engine.Start();
  CHECK_FALSE(IsInMemory(engine, "a"));
  // What does not need the model is known.
  const auto live = Require(engine->FindDatabase("a"));
  REQUIRE(live->lifecycle().served().record() != nullptr);
  CHECK(live->lifecycle().served().record()->version == 1);
  CHECK(Require(live->lifecycle().IsUpToDate()));
  CHECK(server::IsAwaitingChange(engine->CurrentModel(*live).status()));

  const auto model = Require(Model(engine, "a"));
  CHECK(model->model.states() == stored->model.states());
  CHECK(IsInMemory(engine, "a"));
  CHECK_FALSE(IsInMemory(engine, "b"));
  CHECK(Require(Model(engine, "a")) == model);
  CHECK(engine->operations().List("", "", 100)->size() == 2);  // nothing was built again
}

TEST_CASE("Model memory: the model that was not used for the longest time is evicted",
          "[server][memory]") {
  TestEngine engine;
  Fill(engine, {"a", "b", "c"});
  const std::int64_t size = Require(engine->FindDatabase("a"))->lifecycle().model_bytes();
  engine.Stop();
  engine.set_options(WithMemory(5 * size / 2));
  engine.Start();
  REQUIRE_OK(Model(engine, "a"));
  REQUIRE_OK(Model(engine, "b"));
  CHECK(IsInMemory(engine, "a"));
  const auto a = Require(Model(engine, "a"));
  REQUIRE_OK(Model(engine, "c"));
  AwaitInMemory(engine, "b", false);
  CHECK(IsInMemory(engine, "a"));
  CHECK(IsInMemory(engine, "c"));
  // A query keeps its model.
  REQUIRE_OK(Model(engine, "b"));
  AwaitInMemory(engine, "a", false);
  CHECK(a->model.frame_count() > 0);
}

TEST_CASE("Model memory: a query waits for its revision", "[server][memory]") {
  TestEngine engine(WithMemory(kOne));
  Fill(engine, {"a", "b"});
  const std::vector<storage::Change> changes{
      storage::ClipChange{.clip = "walk", .label = "stroll"}};
  const auto edited = Require(engine->Edit("a", changes, "tests", {}));
  engine.Wait(edited.operation->id);
  REQUIRE_OK(Model(engine, "b"));
  AwaitInMemory(engine, "a", false);
  const auto query = Require(Call([&](const server::WorkOptions& terms) {
    return server::Query::Begin(*engine, "a", terms, {"", edited.revision});
  }));
  CHECK(query.revision() >= edited.revision);
  CHECK(query.model().clips()[0].label() == "stroll");
}

TEST_CASE("Model memory: a clip extends a model that is not in memory", "[server][memory]") {
  auto options = WithMemory(kOne);
  options.extend_from = std::chrono::seconds(0);
  TestEngine engine(options);
  engine.Create("a");
  std::string operation;
  for (int i = 0; i < 11; ++i) {  // one more is below 10 %: the model has not drifted
    operation = Require(engine.Ingest("a", "walk" + std::to_string(i), Walk(0.3 * i))).operation.id;
  }
  engine.Wait(operation);
  engine.Wait(Require(engine->ReprocessDatabase("a")).id);
  Fill(engine, {"b"});
  AwaitInMemory(engine, "a", false);
  engine.Wait(Require(engine.Ingest("a", "run", Walk(5))).operation.id);
  const auto model = Require(Model(engine, "a"));
  CHECK(model->record.clip_count == 12);
  CHECK(model->record.added_clip_count == 1);
}

TEST_CASE("Model memory: a corrupt model is reported when it is read, and rebuilt",
          "[server][memory]") {
  TestEngine engine;
  Fill(engine, {"a"});
  engine.Stop();
  RunSql(engine.store_path(), ChangeByte("model_chunk", 100, "position = 0"));
  engine.set_options(WithMemory(kOne));
  engine.Start();
  CHECK(engine->corruptions().empty());
  CHECK(absl::IsFailedPrecondition(Model(engine, "a").status()));  // the build is running
  CHECK(engine->corruptions().size() == 1);
  const auto live = Require(engine->FindDatabase("a"));
  while (live->lifecycle().operation().empty() && engine.ModelVersion("a") < 2) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (const auto operation = live->lifecycle().operation(); !operation.empty()) {
    engine.Wait(operation);
  }
  CHECK(Require(Model(engine, "a"))->record.version == 2);
}

TEST_CASE("Model memory: an error of reading is returned, and reading is tried again",
          "[server][memory]") {
  TestEngine engine;
  Fill(engine, {"a"});
  engine.Stop();
  engine.set_options(WithMemory(kOne));
  engine.Start(absl::UnavailableError("the store does not answer"));
  const auto live = Require(engine->FindDatabase("a"));
  CHECK(absl::IsUnavailable(Model(engine, "a").status()));
  CHECK(absl::IsUnavailable(engine->CurrentModel(*live).status()));
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  CHECK(server::IsAwaitingChange(engine->CurrentModel(*live).status()));
}

TEST_CASE("Model memory: the model of an open stream stays", "[server][memory]") {
  TestEngine engine(WithMemory(kOne));
  Fill(engine, {"a"});
  const auto live = Require(engine->FindDatabase("a"));
  live->AddOpenStreams(1);
  Fill(engine, {"b"});
  REQUIRE_OK(Model(engine, "b"));
  CHECK(IsInMemory(engine, "a"));
  live->AddOpenStreams(-1);
  engine.Wait(Require(engine.Ingest("b", "run", Walk(1))).operation.id);
  AwaitInMemory(engine, "a", false);
}

}  // namespace motiondb::tests::model_memory_test
