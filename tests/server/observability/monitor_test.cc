// The monitor with a real engine: values that change, series that end, and concurrent reads.
#include "server/observability/monitor.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <thread>

#include "core/model/model.h"
#include "tests/support/slow_store.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::monitor_test {
namespace {

using absl::StatusCode;
using Catch::Contains;
using server::CallKind;
using server::CallWatch;
using server::Monitor;
using server::Phase;

StickFigure Walk() { return {.act = Act::kWalk, .frame_count = 60}; }

TEST_CASE("Monitor: ready only while it serves", "[server][monitor]") {
  Monitor monitor({});
  CHECK(!monitor.CheckReadiness().ready);
  CHECK_THAT(monitor.CheckReadiness().reason, Contains("starting"));
  TestEngine engine;
  {
    const Monitor::Attachment attachment(monitor, *engine);
    CHECK(!monitor.CheckReadiness().ready);
    monitor.SetPhase(Phase::kServing);
    CHECK(monitor.CheckReadiness().ready);
    monitor.SetPhase(Phase::kDraining);
    CHECK(!monitor.CheckReadiness().ready);
    CHECK_THAT(monitor.CheckReadiness().reason, Contains("draining"));
  }
  monitor.SetPhase(Phase::kServing);
  CHECK(!monitor.CheckReadiness().ready);  // there is no engine
}

// A store that can stop being readable.
class LosableStore final : public GatedStore {
 public:
  explicit LosableStore(const std::atomic<bool>& lost)
      : GatedStore(*storage::SqliteMotionStore::Open(":memory:"), std::make_shared<Gate>()),
        lost_(lost) {}
  absl::StatusOr<std::vector<storage::DatabaseRecord>> ListDatabases(
      const storage::Page& page) override {
    if (lost_) return absl::UnavailableError("disk I/O error");
    return GatedStore::ListDatabases(page);
  }

 private:
  const std::atomic<bool>& lost_;
};

TEST_CASE("Monitor: not ready while the store cannot be read", "[server][monitor]") {
  std::atomic<bool> lost = false;
  Monitor monitor({});
  const auto engine =
      server::Engine::Open(std::make_unique<LosableStore>(lost), TestEngine::QuickOptions());
  REQUIRE(engine.ok());
  const Monitor::Attachment attachment(monitor, **engine);
  monitor.SetPhase(Phase::kServing);
  CHECK(monitor.CheckReadiness().ready);
  lost = true;
  CHECK(!monitor.CheckReadiness().ready);
  CHECK(monitor.CheckReadiness().reason == "the store cannot be read: disk I/O error");
  lost = false;
  CHECK(monitor.CheckReadiness().ready);
}

TEST_CASE("Monitor: not ready while the store's file is gone", "[server][monitor]") {
  const TemporaryDirectory directory;
  const std::string path = directory / "store.db";
  Monitor monitor({});
  const auto engine =
      server::Engine::Open(*storage::SqliteMotionStore::Open(path), TestEngine::QuickOptions());
  REQUIRE(engine.ok());
  const Monitor::Attachment attachment(monitor, **engine);
  monitor.SetPhase(Phase::kServing);
  CHECK(monitor.CheckReadiness().ready);
  std::filesystem::rename(path, directory / "aside.db");
  CHECK(!monitor.CheckReadiness().ready);
  CHECK_THAT(monitor.CheckReadiness().reason,
             Contains("the store's file '" + path + "' is gone") && Contains("put the file back"));
  std::filesystem::rename(directory / "aside.db", path);
  CHECK(monitor.CheckReadiness().ready);
}

TEST_CASE("Monitor: calls are counted by method and code", "[server][monitor]") {
  Monitor monitor({.methods = {"QueryService.Plan", "ObserveService.Observe"}});
  CHECK_THAT(monitor.Exposition(),
             Contains("motiondb_requests_total{code=\"OK\",method=\"QueryService.Plan\"} 0\n"));
  // An alert on the first error needs a previous value of 0.
  for (const StatusCode code :
       {StatusCode::kInternal, StatusCode::kUnknown, StatusCode::kDataLoss}) {
    CAPTURE(code);
    CHECK(server::IsServerFault(code));
    CHECK_THAT(monitor.Exposition(),
               Contains("motiondb_requests_total{code=\"" + std::string(server::CodeName(code)) +
                        "\",method=\"QueryService.Plan\"} 0\n"));
  }
  {
    CallWatch plan(monitor, "QueryService.Plan", CallKind::kWork);
    CallWatch stream(monitor, "ObserveService.Observe", CallKind::kFrames);
    CallWatch unknown(monitor, "QueryService.Guess", CallKind::kWork);
    CHECK(monitor.calls().open() == 3);
    CHECK(monitor.calls().open_streams() == 1);
    plan.End(StatusCode::kOk, "", "id", "peer");
    unknown.End(StatusCode::kUnauthenticated, "", "id", "peer");
    CHECK(monitor.calls().open() == 1);
    CHECK(monitor.calls().ended() == 2);
  }
  const std::string text = monitor.Exposition();
  CHECK_THAT(text,
             Contains("motiondb_requests_total{code=\"OK\",method=\"QueryService.Plan\"} 1\n") &&
                 Contains("code=\"CANCELLED\",method=\"ObserveService.Observe\"} 1\n") &&
                 Contains("code=\"UNAUTHENTICATED\",method=\"other\"} 1\n") &&
                 Contains("motiondb_request_seconds_count{method=\"QueryService.Plan\"} 1\n") &&
                 Contains("motiondb_authentication_failures_total 1\n") &&
                 Contains("motiondb_open_requests 0\n") && Contains("motiondb_open_streams 0\n"));
  monitor.calls().CountRefusedAttempt();
  CHECK_THAT(monitor.Exposition(), Contains("motiondb_authentication_failures_total 2\n"));
  CHECK(monitor.calls().failed() == 0);
  CallWatch(monitor, "QueryService.Plan", CallKind::kWork)
      .End(StatusCode::kInternal, "", "id", "peer");
  CHECK(monitor.calls().failed() == 1);
  const auto figures = monitor.CollectStatistics();
  CHECK(figures.ended_calls == 4);
  CHECK(figures.authentication_failures == 2);
  REQUIRE(figures.methods.size() == 3);
  CHECK(figures.methods[0].method == "ObserveService.Observe");
  CHECK(figures.methods[1].method == "QueryService.Plan");
  CHECK(figures.methods[1].ended == 2);
  REQUIRE(figures.methods[1].errors.size() == 1);
  CHECK(figures.methods[1].errors[0] == std::pair(StatusCode::kInternal, std::int64_t{1}));
  CHECK(figures.methods[1].seconds.p99 > 0);
  CHECK(figures.methods[2].method == "other");
}

TEST_CASE("Monitor: counts all calls of many threads", "[server][monitor]") {
  Monitor monitor({.methods = {"QueryService.Plan"}});
  std::vector<std::thread> threads;
  for (int thread = 0; thread < 4; ++thread) {
    threads.emplace_back([&] {
      for (int i = 0; i < 1000; ++i) {
        CallWatch(monitor, "QueryService.Plan", CallKind::kWork)
            .End(i % 2 == 0 ? StatusCode::kOk : StatusCode::kNotFound, "", "id", "peer");
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK_THAT(monitor.Exposition(),
             Contains("{code=\"NOT_FOUND\",method=\"QueryService.Plan\"} 2000\n") &&
                 Contains("motiondb_request_seconds_count{method=\"QueryService.Plan\"} 4000\n"));
}

TEST_CASE("Monitor: databases, their models and builds, until they are deleted",
          "[server][monitor]") {
  TestEngine engine;
  Monitor monitor({});
  const Monitor::Attachment attachment(monitor, *engine);
  engine.Create("walks");
  engine.gate().Close();
  const auto ingested = engine.Ingest("walks", "walk", Walk());
  REQUIRE(ingested.ok());
  engine.gate().AwaitArrival();
  CHECK_THAT(monitor.Exposition(),
             Contains("motiondb_database_clips{database=\"walks\"} 1\n") &&
                 Contains("motiondb_rebuild_pending{database=\"walks\"} 1\n") &&
                 Contains("motiondb_model_version{database=\"walks\"} 0\n"));
  engine.gate().Open();
  engine.Wait(ingested->operation.id);
  const auto figures = monitor.CollectStatistics();
  REQUIRE(figures.databases.size() == 1);
  REQUIRE(figures.databases[0].model.has_value());
  CHECK(figures.databases[0].model->version == 1);
  CHECK(figures.databases[0].model_age_seconds < 60);
  CHECK(figures.databases[0].rebuilds.succeeded == 1);
  CHECK(figures.databases[0].rebuilds.seconds > 0);
  CHECK(figures.process.resident_bytes > 1 << 20);
  CHECK(figures.process.open_descriptors > 3);
  REQUIRE(engine->DeleteDatabase("walks").ok());
  CHECK_THAT(monitor.Exposition(), !Contains("walks"));
}

TEST_CASE("Monitor: statistics do not wait for a slow disk", "[server][monitor]") {
  const auto disk = std::make_shared<Gate>();
  const auto engine =
      server::Engine::Open(std::make_unique<SlowStore>(disk), TestEngine::QuickOptions());
  REQUIRE(engine.ok());
  Monitor monitor({});
  const Monitor::Attachment attachment(monitor, **engine);
  const core::BuildSettings settings{.frame_rate_hz = 60, .min_frames = 4};
  REQUIRE((*engine)->CreateDatabase("walks", settings, {server::kSourceMarkerSet, ""}).ok());
  disk->Close();
  bool ingested = false;
  std::thread ingesting([&] {
    storage::NewClip clip;
    clip.record.file_name = "walk.bvh";
    clip.file_bytes = WriteBvh(Walk());
    ingested = (*engine)->Ingest(*(*engine)->FindDatabase("walks"), {std::move(clip)}, {}).ok();
  });
  disk->AwaitArrival();
  CHECK_THAT(monitor.Exposition(),
             Contains("motiondb_database_clips{database=\"walks\"} 1\n") &&
                 Contains("motiondb_rebuild_pending{database=\"walks\"} 0\n"));
  disk->Open();
  ingesting.join();
  CHECK(ingested);
}

TEST_CASE("Monitor: is read while databases are created and deleted", "[server][monitor]") {
  TestEngine engine;
  Monitor monitor({});
  const Monitor::Attachment attachment(monitor, *engine);
  monitor.SetPhase(Phase::kServing);
  std::atomic<bool> stop = false;
  std::vector<std::thread> readers;
  std::atomic<int> read = 0;
  for (int i = 0; i < 2; ++i) {
    readers.emplace_back([&] {
      while (!stop) {
        if (monitor.Exposition().find("motiondb_databases ") != std::string::npos) ++read;
        if (!monitor.CheckReadiness().ready) stop = true;
      }
    });
  }
  for (int round = 0; round < 10; ++round) {
    const std::string name = "db" + std::to_string(round % 3);
    engine.Create(name);
    CHECK(engine.Ingest(name, "walk", Walk()).ok());
    CHECK(engine->DeleteDatabase(name).ok());
  }
  CHECK(!stop);
  stop = true;
  for (std::thread& reader : readers) reader.join();
  CHECK(read > 0);
  CHECK_THAT(monitor.Exposition(), Contains("motiondb_databases 0\n"));
}

}  // namespace
}  // namespace motiondb::tests::monitor_test
