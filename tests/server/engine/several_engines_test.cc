// Several engines on one store, as several servers on one PostgreSQL.
#include <spdlog/spdlog.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/engine/engine.h"
#include "storage/blob/newer_format.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/storage/require_ok.h"
#include "tests/support/gated_store.h"
#include "tests/support/stick_figure.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::several_engines_test {
namespace {

using std::chrono::seconds;
using storage::OperationState;

// What a test controls and sees of the access of a server to the store.
struct Access {
  std::atomic<bool> is_stopped{false};  // leases are not renewed, nothing is looked at or purged
  std::atomic<bool> is_old{false};      // stored models are of a newer version
  storage::OnStoreChange on_change;     // what a notification calls
  std::function<void()> after_read;     // called when the first model was read
  std::atomic<int> look_count{0};
  std::atomic<int> purge_count{0};
};

class WatchedStore final : public SharedStore {
 public:
  WatchedStore(std::shared_ptr<storage::MotionStore> store, std::shared_ptr<Gate> model_gate,
               Access& access)
      : SharedStore(std::move(store), std::make_shared<Gate>(), std::move(model_gate)),
        access_(access) {}
  std::unique_ptr<storage::StoreWatch> WatchChanges(storage::OnStoreChange on_change) override {
    access_.on_change = std::move(on_change);
    return std::make_unique<Watch>();
  }
  absl::Status PurgeDeletedDatabases(const core::Cancelled& cancelled) override {
    if (access_.is_stopped) return absl::UnavailableError("the store is cut off");
    const absl::Status purged = GatedStore::PurgeDeletedDatabases(cancelled);
    if (purged.ok()) ++access_.purge_count;
    return purged;
  }
  absl::StatusOr<std::vector<storage::DatabaseState>> ListDatabaseStates() override {
    if (access_.is_stopped) return absl::UnavailableError("the store is cut off");
    ++access_.look_count;
    return GatedStore::ListDatabaseStates();
  }
  absl::StatusOr<core::Model> ReadModel(const std::string& database,
                                        const core::ParallelFor& parallel) override {
    if (access_.is_old) return storage::NewerFormat("model");
    auto model = GatedStore::ReadModel(database, parallel);
    if (access_.after_read) std::exchange(access_.after_read, nullptr)();
    return model;
  }
  absl::StatusOr<core::Model> ReadExtension(const std::string& database, std::int32_t base_version,
                                            const core::Model& base,
                                            const core::ParallelFor& parallel) override {
    if (access_.is_old) return storage::NewerFormat("model");
    return GatedStore::ReadExtension(database, base_version, base, parallel);
  }
  absl::Status RenewBuildLease(const std::string& database, std::int64_t fence,
                               std::chrono::milliseconds duration) override {
    if (access_.is_stopped) return absl::UnavailableError("the process is stopped");
    return GatedStore::RenewBuildLease(database, fence, duration);
  }

 private:
  struct Watch final : storage::StoreWatch {};

  Access& access_;
};

// An engine with its store.
struct OneServer : Access {
  explicit OneServer(const std::shared_ptr<storage::MotionStore>& store,
                     const server::EngineOptions& options = TestEngine::QuickOptions(),
                     std::function<void()> on_read = {}) {
    after_read = std::move(on_read);
    engine = Require(
        server::Engine::Open(std::make_unique<WatchedStore>(store, model_gate, *this), options));
  }
  ~OneServer() { model_gate->Open(); }

  std::shared_ptr<Gate> model_gate = std::make_shared<Gate>();  // closed: models are not stored
  std::unique_ptr<server::Engine> engine;
};

std::shared_ptr<storage::MotionStore> NewStore() {
  spdlog::set_level(spdlog::level::off);
  return Require(storage::SqliteMotionStore::Open(":memory:"));
}

void Create(OneServer& server, const std::string& name) {
  REQUIRE_OK(server.engine->CreateDatabase(name, {.frame_rate_hz = 60, .min_frames = 4},
                                           {server::kSourceMarkerSet, ""}));
}

absl::StatusOr<server::Ingested> TryIngest(OneServer& server, const std::string& clip,
                                           double phase) {
  const auto live = Require(server.engine->FindDatabase("d"));
  const auto in_flight = Require(server.engine->BeginIngest(live));
  storage::NewClip request;
  request.record.file_name = clip + ".bvh";
  request.file_bytes = WriteBvh(Walk(phase));
  return server.engine->Ingest(live, {std::move(request)}, {});
}

storage::OperationRecord Ingest(OneServer& server, const std::string& clip, double phase) {
  return Require(TryIngest(server, clip, phase)).operation;
}

template <typename Condition>
void Await(const Condition& condition, seconds limit = seconds(20)) {
  const auto latest = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    REQUIRE(std::chrono::steady_clock::now() < latest);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

bool Serves(OneServer& server, int clips) {
  server.engine->LookNow();
  const auto live = server.engine->FindDatabase("d");
  if (!live.ok()) return false;
  const auto snapshot = (*live)->lifecycle().snapshot();
  return snapshot != nullptr && snapshot->is_stored() && snapshot->record.clip_count == clips;
}

OperationState StateOf(OneServer& server, const std::string& operation) {
  return Require(server.engine->operations().Get(operation)).state;
}

server::LeaseTally LeasesOf(OneServer& server) {
  return Require(server.engine->FindDatabase("d"))->lifecycle().leases();
}

// Creates the database `d` with one clip, waits until it is built and nothing is left to do, and
// returns the id of the clip.
std::string BuildOneClip(OneServer& server, storage::MotionStore& store) {
  Create(server, "d");
  Ingest(server, "walk", 0.1);
  Await([&] { return Serves(server, 1); });
  Await([&] { return store.ListUnfinishedOperations()->empty(); });
  return Require(store.ListClips("d", {.after = "", .limit = 1}))[0].id;
}

int VersionOf(OneServer& server) {
  return Require(server.engine->FindDatabase("d"))->lifecycle().snapshot()->record.version;
}

}  // namespace

TEST_CASE("Engines on one store: each serves what the others change", "[server][servers]") {
  auto options = TestEngine::QuickOptions();
  options.extend_from = std::chrono::duration<double>(GENERATE(0, 3600));
  const auto store = NewStore();
  OneServer a(store, options);
  OneServer b(store, options);
  Create(a, "d");
  Await([&] { return b.engine->FindDatabase("d").ok(); });
  const auto first = Ingest(b, "walk", 0.1);
  Await([&] { return Serves(a, 1) && Serves(b, 1); });
  Await([&] { return StateOf(a, first.id) == OperationState::kSucceeded; });
  Ingest(a, "walk", 0.2);
  Ingest(b, "walk", 0.3);
  Await([&] { return Serves(a, 3) && Serves(b, 3); });
  Await([&] { return store->ListUnfinishedOperations()->empty(); });
  Await([&] { return VersionOf(a) == VersionOf(b); });
  CHECK(Require(b.engine->FindDatabase("d"))->stored().clip_count == 3);

  storage::ClipChange label;
  label.clip = "walk";
  label.label = "stroll";
  const auto edited = Require(a.engine->Edit("d", std::vector<storage::Change>{label}, "somebody"));
  Await([&] {
    b.engine->LookNow();
    const auto live = Require(b.engine->FindDatabase("d"));
    return live->lifecycle().served().revision >= edited.revision;
  });
  CHECK(Require(b.engine->FindDatabase("d"))->seen_revision() == edited.revision);
  CHECK(b.engine->SecondsSinceLook() > 0);
  CHECK(b.engine->SecondsSinceLook() < 10);

  REQUIRE_OK(b.engine->DeleteDatabase("d"));
  Await([&] {
    a.engine->LookNow();
    return !a.engine->FindDatabase("d").ok();
  });
  Create(b, "d");
  Await([&] {
    a.engine->LookNow();
    return a.engine->FindDatabase("d").ok();
  });
  CHECK(Require(a.engine->FindDatabase("d"))->lifecycle().snapshot() == nullptr);
}

TEST_CASE("Engines on one store: a builder that stops is replaced and publishes nothing",
          "[server][servers]") {
  const auto store = NewStore();
  OneServer a(store);
  Create(a, "d");
  a.model_gate->Close();
  const auto operation = Ingest(a, "walk", 0.1);
  a.model_gate->AwaitArrival();
  a.is_stopped = true;
  OneServer b(store);
  const auto began = std::chrono::steady_clock::now();
  Await([&] { return Serves(b, 1); });
  CHECK(std::chrono::steady_clock::now() - began < seconds(10));
  Await([&] { return StateOf(b, operation.id) == OperationState::kSucceeded; });
  const auto models = store->ListModels("d", 0, 10)->size();
  CHECK(LeasesOf(a).acquired == 1);
  CHECK(LeasesOf(b).acquired >= 1);
  CHECK(LeasesOf(b).refused >= 1);
  Ingest(b, "walk", 0.2);
  Await([&] { return Serves(b, 2); });
  a.is_stopped = false;
  a.model_gate->Open();
  Await([&] { return Serves(a, 2); });
  CHECK(VersionOf(a) == VersionOf(b));
  CHECK(LeasesOf(a).lost == 1);
  CHECK_FALSE(LeasesOf(a).is_held);
  CHECK(LeasesOf(b).lost == 0);
  CHECK(store->ListModels("d", 0, 10)->size() == models + 1);
  CHECK(StateOf(a, operation.id) == OperationState::kSucceeded);
}

TEST_CASE("Engines on one store: looks soon after each notification, once after many",
          "[server][servers]") {
  const auto store = NewStore();
  OneServer a(store);
  Await([&] { return a.look_count > 0; });
  constexpr int kRounds = 10;
  const auto began = std::chrono::steady_clock::now();
  for (int round = 0; round < kRounds; ++round) {
    const int before = a.look_count;
    for (int i = 0; i < 100; ++i) a.on_change({});
    Await([&] { return a.look_count > before; });
  }
  // Without notifications: a look in each second.
  CHECK(std::chrono::steady_clock::now() - began < seconds(kRounds) / 2);
  CHECK(a.look_count < 5 * kRounds);
}

TEST_CASE("Engines on one store: a model is replaced while a server that starts reads it",
          "[server][servers]") {
  const auto store = NewStore();
  OneServer a(store);
  Create(a, "d");
  Ingest(a, "walk", 0.1);
  Await([&] { return Serves(a, 1); });
  OneServer b(store, TestEngine::QuickOptions(), [&] {
    Ingest(a, "walk", 0.2);
    Await([&] { return Serves(a, 2); });
  });
  const auto served = Require(b.engine->FindDatabase("d"))->lifecycle().snapshot();
  REQUIRE(served != nullptr);
  CHECK(static_cast<std::size_t>(served->record.clip_count) == served->model.clips().size());
}

TEST_CASE("Engines on one store: a change of a deleted database is not made in one of its name",
          "[server][servers]") {
  const auto store = NewStore();
  OneServer a(store);
  OneServer b(store);
  const std::string clip = BuildOneClip(a, *store);
  Await([&] { return Serves(b, 1); });
  Create(b, "other");  // SQLite uses the last key again
  // From now on, `b` does not see what `a` changes.
  b.is_stopped = true;
  Await([&] { return b.engine->SecondsSinceLook() > 1.1; });
  REQUIRE_OK(a.engine->DeleteDatabase("d"));
  Create(a, "d");

  const auto is_refused = [](const auto& changed) {
    return motiondb::tests::StatusOf(changed).code() == absl::StatusCode::kAborted;
  };
  const auto stale = Require(b.engine->FindDatabase("d"));
  CHECK(is_refused(TryIngest(b, "walk", 0.2)));
  CHECK(is_refused(b.engine->ReprocessDatabase("d")));
  CHECK(Require(store->ListClips("d", {})).empty());
  CHECK(Require(store->ListOperations("d", "", 10)).empty());
  Ingest(a, "walk", 0.1);
  Await([&] { return Serves(a, 1); });
  CHECK(is_refused(TryIngest(b, "walk", 0.2)));
  CHECK(is_refused(b.engine->DeleteClip("d", clip)));
  storage::ClipChange label{.clip = clip};
  label.label = "stroll";
  CHECK(is_refused(b.engine->Edit("d", std::vector<storage::Change>{label}, "somebody")));
  CHECK(Require(store->ListClips("d", {})).size() == 1);
  CHECK(Require(store->GetClip("d", clip)).label != "stroll");
  CHECK(is_refused(b.engine->DeleteDatabase("d")));
  CHECK(Require(store->GetDatabase("d")).id != stale->id());

  b.is_stopped = false;
  Await([&] {
    b.engine->LookNow();
    const auto live = b.engine->FindDatabase("d");
    return live.ok() && *live != stale && Serves(b, 1);
  });
  REQUIRE_OK(TryIngest(b, "walk", 0.2));
  Await([&] { return Serves(a, 2) && Serves(b, 2); });
}

TEST_CASE("Engines on one store: a build is cancelled on any server", "[server][servers]") {
  const auto store = NewStore();
  OneServer a(store);
  OneServer b(store);
  Create(a, "d");
  a.model_gate->Close();
  const auto operation = Ingest(a, "walk", 0.1);
  a.model_gate->AwaitArrival();
  const auto cancellation = Require(b.engine->CancelOperation(operation.id));
  CHECK(cancellation.is_first);
  CHECK(cancellation.operation.state == OperationState::kCancelled);
  CHECK_FALSE(Require(b.engine->CancelOperation(operation.id)).is_first);
  a.model_gate->Open();
  Await([&] { return StateOf(a, operation.id) == OperationState::kCancelled; });
  CHECK(store->GetOperation(operation.id)->state == OperationState::kCancelled);
}

TEST_CASE("Engines on one store: space is freed after an outage", "[server][servers]") {
  const auto store = NewStore();
  OneServer a(store);
  Create(a, "d");
  Await([&] { return a.purge_count == 1; });  // at the start
  a.is_stopped = true;
  Await([&] {
    a.engine->LookNow();
    return a.engine->SecondsSinceLook() > 0.5;
  });
  REQUIRE_OK(a.engine->DeleteDatabase("d"));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  CHECK(a.purge_count == 1);
  a.is_stopped = false;
  Await([&] { return a.purge_count == 2; });
}

// Returns the fencing number of a lease that no server has.
std::int64_t AcquireLease(storage::MotionStore& store) {
  absl::StatusOr<std::int64_t> fence;
  Await([&] {
    fence = store.AcquireBuildLease("d", "another", std::chrono::hours(1));
    return fence.ok();
  });
  return *fence;
}

// Changes a stored clip as a server of another version, or with another clock, would.
template <typename Change>
void ChangeClip(storage::MotionStore& store, const std::string& id, const Change& change) {
  const std::int64_t fence = AcquireLease(store);
  storage::DerivedClip derived{.record = Require(store.GetClip("d", id)), .states = std::nullopt};
  change(derived.record);
  REQUIRE(Require(store.PutDerived("d", std::span(&derived, 1), fence)).size() == 1);
  REQUIRE_OK(store.ReleaseBuildLease("d", fence));
}

TEST_CASE("Engines on one store: a server does not build clips of a newer version",
          "[server][servers]") {
  const auto store = NewStore();
  OneServer old(store);
  const std::string clip = BuildOneClip(old, *store);
  const int version = VersionOf(old);
  const auto set_version = [&](int representation) {
    ChangeClip(*store, clip, [&](storage::ClipRecord& record) {
      record.representation_version = record.tried_version = representation;
    });
  };
  set_version(core::kRepresentationVersion + 1);
  const auto operation = Ingest(old, "walk", 0.2);
  const auto reprocess = Require(old.engine->ReprocessDatabase("d"));
  std::this_thread::sleep_for(std::chrono::milliseconds(2500));
  CHECK_FALSE(store->GetOperation(operation.id)->done());
  CHECK_FALSE(store->GetOperation(reprocess.id)->done());
  CHECK(VersionOf(old) == version);
  CHECK(store->GetClip("d", clip)->representation_version == core::kRepresentationVersion + 1);
  set_version(core::kRepresentationVersion);
  Await([&] { return Serves(old, 2); });
  Await([&] { return store->GetOperation(operation.id)->state == OperationState::kSucceeded; });
}

TEST_CASE("Engines on one store: an older server does not replace a model of a newer version",
          "[server][servers]") {
  auto options = TestEngine::QuickOptions();
  options.extend_from = std::chrono::duration<double>(GENERATE(0, 3600));
  options.rebuild_retry_delay = seconds(2);
  const auto store = NewStore();
  OneServer old(store, options);
  BuildOneClip(old, *store);
  old.is_old = true;
  const int version = VersionOf(old);
  {
    OneServer newer(store, options);
    Ingest(newer, "walk", 0.2);
    Await([&] { return Serves(newer, 2); });
    const auto operation = Ingest(old, "walk", 0.3);
    Await([&] { return Serves(newer, 3); });
    Await([&] { return store->GetOperation(operation.id)->state == OperationState::kSucceeded; });
    CHECK(Require(store->ListModels("d", 0, 1))[0].version == VersionOf(newer));
    CHECK(VersionOf(old) == version);
  }
  const int newest = Require(store->ListModels("d", 0, 1))[0].version;
  const auto operation = Ingest(old, "walk", 0.4);
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  CHECK_FALSE(store->GetOperation(operation.id)->done());
  CHECK(Require(store->ListModels("d", 0, 1))[0].version == newest);
  CHECK(VersionOf(old) == version);
  old.is_old = false;
  Await([&] { return Serves(old, 4); });
}

TEST_CASE("Engines on one store: a clip of a server whose clock is ahead is derived again",
          "[server][servers]") {
  const auto store = NewStore();
  OneServer a(store);
  const std::string clip = BuildOneClip(a, *store);
  std::int64_t tried_us = 0;
  ChangeClip(*store, clip,
             [&](storage::ClipRecord& record) { tried_us = record.tried_time_us += 8'000'000; });
  const auto operation = Require(a.engine->ReprocessDatabase("d"));
  Await([&] { return store->GetOperation(operation.id)->done(); });
  CHECK(store->GetClip("d", clip)->tried_time_us < tried_us);
}

TEST_CASE("Engines on one store: only servers that build do so", "[server][servers]") {
  const auto store = NewStore();
  auto options = TestEngine::QuickOptions();
  options.work = server::ServerWork::kServe;
  OneServer serves(store, options);
  Create(serves, "d");
  const auto operation = Ingest(serves, "walk", 0.1);
  std::this_thread::sleep_for(seconds(1));
  CHECK(StateOf(serves, operation.id) == OperationState::kPending);
  OneServer builds(store);
  Await([&] { return Serves(serves, 1); });
  Await([&] { return StateOf(serves, operation.id) == OperationState::kSucceeded; });
}

}  // namespace motiondb::tests::several_engines_test
