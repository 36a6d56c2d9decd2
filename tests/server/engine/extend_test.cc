// Clips become known without a build, if builds take long.
#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

#include "core/calibration/calibrate.h"
#include "core/recognition/recognize.h"
#include "server/engine/compute_model.h"
#include "server/engine/snapshot.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::extend_test {
namespace {

using std::chrono::milliseconds;
using storage::OperationState;

server::EngineOptions Extending() {
  auto options = TestEngine::QuickOptions();
  options.extend_from = std::chrono::seconds(0);
  return options;
}

// Creates a database with `clips` walks and builds its model.
void BuildWalks(TestEngine& engine, int clips) {
  engine.Create("db");
  std::string operation;
  for (int c = 0; c < clips; ++c) {
    operation = engine.Ingest("db", "c" + std::to_string(100 + c), Walk(0.1 * c))->operation.id;
  }
  engine.Wait(operation);
}

std::shared_ptr<const server::Snapshot> Current(TestEngine& engine) {
  return (*engine->FindDatabase("db"))->lifecycle().snapshot();
}

bool Knows(const server::Snapshot& snapshot, const std::string& clip) {
  return std::ranges::any_of(snapshot.model.clips(),
                             [&](const core::ModelClip& known) { return known.id == clip; });
}

// Waits up to a minute until the clip is in the model.
std::shared_ptr<const server::Snapshot> AwaitKnown(TestEngine& engine, const std::string& clip) {
  for (int i = 0; i < 6000; ++i) {
    const auto snapshot = Current(engine);
    if (snapshot != nullptr && Knows(*snapshot, clip)) return snapshot;
    std::this_thread::sleep_for(milliseconds(10));
  }
  FAIL("clip '" << clip << "' is not known");
  return nullptr;
}

}  // namespace

TEST_CASE("Extend: a clip is known while its build has not begun", "[server][extend]") {
  TestEngine engine(Extending());
  BuildWalks(engine, 20);
  engine.Stop();
  auto options = Extending();
  options.rebuild_delay = options.rebuild_delay_limit = std::chrono::hours(1);
  engine.set_options(options);
  engine.Start();
  const auto waiting = engine.Ingest("db", "more", Walk(0.25));
  REQUIRE(waiting.ok());
  const auto extended = AwaitKnown(engine, "more");
  CHECK(extended->record.added_clip_count == 1);
  CHECK(engine->operations().Get(waiting->operation.id)->state == OperationState::kPending);
}

TEST_CASE("Extend: an operation ends without a build if few frames were added",
          "[server][extend]") {
  TestEngine engine(Extending());
  BuildWalks(engine, 20);
  const auto built = Current(engine);
  const auto operation = engine.Wait(engine.Ingest("db", "more", Walk(0.25))->operation.id);
  REQUIRE(operation.state == OperationState::kSucceeded);
  const auto extended = Current(engine);
  CHECK(Knows(*extended, "more"));
  CHECK(extended->record.version == operation.model_version);
  CHECK(extended->record.version == built->record.version + 1);
  CHECK(extended->record.added_clip_count == 1);
  CHECK(extended->record.added_frame_count == 60);
  CHECK(extended->model.built_clip_count() == 20);
  CHECK_FALSE(server::HasDrifted(extended->record));

  SECTION("and a restart builds nothing") {
    engine.Stop();
    engine.Start();
    const auto after = Current(engine);
    REQUIRE(after != nullptr);
    CHECK(after->record.version == extended->record.version);
    CHECK(after->record.added_clip_count == 1);
    CHECK(after->model.states() == extended->model.states());
    CHECK(after->model.tree().frame_order() == extended->model.tree().frame_order());
    CHECK(after->model.gaussians().means() == extended->model.gaussians().means());
    CHECK(engine->operations().List("db", "", 10)->front().id == operation.id);
  }
  SECTION("a tenth more frames cause a build") {
    REQUIRE(engine.Ingest("db", "x1", Walk(0.21)).ok());
    const auto last = engine.Wait(engine.Ingest("db", "x2", Walk(0.22))->operation.id);
    REQUIRE(last.state == OperationState::kSucceeded);
    const auto rebuilt = Current(engine);
    CHECK(rebuilt->record.version == last.model_version);
    CHECK(rebuilt->record.added_clip_count == 0);
    CHECK(rebuilt->model.clips().size() == 23);
    CHECK_THAT(last.stage, Catch::StartsWith(
                               "done, replaced extended model with 3 added clips: bottom nodes "));
  }
  SECTION("a deleted clip causes a build") {
    const auto deletion = engine->DeleteClip("db", "more");
    REQUIRE(deletion.ok());
    REQUIRE(engine.Wait(deletion->id).state == OperationState::kSucceeded);
    CHECK(Current(engine)->model.clips().size() == 20);
    CHECK(Current(engine)->record.added_clip_count == 0);
  }
}

TEST_CASE("Extend: a clip that comes during a build is known before and after it",
          "[server][extend]") {
  TestEngine engine(Extending());
  BuildWalks(engine, 20);
  engine.model_gate().Close();
  std::string operation;
  for (int c = 0; c < 5; ++c) {  // enough that a build follows
    operation = engine.Ingest("db", "new" + std::to_string(c), Walk(0.03 * c + 2.51))->operation.id;
  }
  engine.model_gate().AwaitArrival();
  // The new model has them from its build, and answers while it is stored.
  const auto built = AwaitKnown(engine, "new4");
  CHECK_FALSE(built->is_stored());
  CHECK(built->record.added_clip_count == 0);
  CHECK(built->model.clips().size() == 25);
  // The extension waits until the model is stored, and extends that model.
  const auto late = engine.Ingest("db", "late", Walk(0.75));
  REQUIRE(late.ok());
  engine.model_gate().Open();
  REQUIRE(engine.Wait(operation).state == OperationState::kSucceeded);
  const auto known = AwaitKnown(engine, "late");
  CHECK(known->model.clips().size() == 26);
  CHECK(Knows(*known, "new4"));
  engine.Wait(late->operation.id);
  CHECK(Current(engine)->model.clips().size() == 26);
}

TEST_CASE("Extend: queries are answered during extensions", "[server][extend]") {
  TestEngine engine(Extending());
  BuildWalks(engine, 20);
  std::atomic<bool> stop{false};
  std::atomic<int> answered{0};
  std::vector<std::thread> clients;
  for (int i = 0; i < 3; ++i) {
    clients.emplace_back([&] {
      while (!stop) {
        const auto snapshot = Current(engine);
        const auto clip = static_cast<int>(snapshot->model.clips().size()) - 1;
        const auto windows =
            core::Recognize(snapshot->model, core::StoredMotion(snapshot->model, clip), {});
        if (windows.ok() && !windows->empty()) ++answered;
      }
    });
  }
  for (int c = 0; c < 8; ++c) {
    const std::string name = "new" + std::to_string(c);
    REQUIRE(engine.Ingest("db", name, Walk(0.03 * c + 2.51)).ok());
    AwaitKnown(engine, name);
  }
  stop = true;
  for (std::thread& client : clients) client.join();
  CHECK(answered > 0);
}

TEST_CASE("Extend: a model with short builds is rebuilt", "[server][extend]") {
  TestEngine engine;
  BuildWalks(engine, 20);
  engine.Wait(engine.Ingest("db", "more", Walk(0.25))->operation.id);
  CHECK(Current(engine)->record.added_clip_count == 0);
  CHECK(Current(engine)->model.clips().size() == 21);
}

}  // namespace motiondb::tests::extend_test
