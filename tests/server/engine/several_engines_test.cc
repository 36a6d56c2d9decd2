// Several engines on one store, as several servers on one PostgreSQL.
#include <spdlog/spdlog.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "server/engine/engine.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/storage/require_ok.h"
#include "tests/support/gated_store.h"
#include "tests/support/stick_figure.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::several_engines_test {
namespace {

using std::chrono::seconds;
using storage::OperationState;

// The way of one engine to a store that others share.
class SharedStore final : public GatedStore {
 public:
  // Sets `on_change` to what a notification calls, and counts the looks at the store.
  SharedStore(std::shared_ptr<storage::MotionStore> store, std::shared_ptr<Gate> model_gate,
              const std::atomic<bool>& is_stopped, storage::OnStoreChange& on_change,
              std::atomic<int>& look_count)
      : GatedStore(std::move(store), std::make_shared<Gate>(), std::move(model_gate)),
        is_stopped_(is_stopped),
        on_change_(&on_change),
        look_count_(&look_count) {}
  bool is_shared() const override { return true; }
  std::unique_ptr<storage::StoreWatch> WatchChanges(storage::OnStoreChange on_change) override {
    *on_change_ = std::move(on_change);
    return std::make_unique<Watch>();
  }
  absl::StatusOr<std::vector<storage::DatabaseState>> ListDatabaseStates() override {
    ++*look_count_;
    return GatedStore::ListDatabaseStates();
  }
  absl::Status RenewBuildLease(const std::string& database, std::int64_t fence,
                               std::chrono::milliseconds duration) override {
    if (is_stopped_) return absl::UnavailableError("the process is stopped");
    return GatedStore::RenewBuildLease(database, fence, duration);
  }

 private:
  struct Watch final : storage::StoreWatch {};

  const std::atomic<bool>& is_stopped_;
  storage::OnStoreChange* const on_change_;
  std::atomic<int>* const look_count_;
};

// An engine with its store.
struct OneServer {
  explicit OneServer(const std::shared_ptr<storage::MotionStore>& store,
                     server::EngineOptions options = TestEngine::QuickOptions())
      : engine(Require(server::Engine::Open(
            std::make_unique<SharedStore>(store, model_gate, is_stopped, on_change, look_count),
            options))) {}
  ~OneServer() { model_gate->Open(); }

  std::shared_ptr<Gate> model_gate = std::make_shared<Gate>();  // closed: models are not stored
  std::atomic<bool> is_stopped{false};                          // leases are not renewed
  storage::OnStoreChange on_change;
  std::atomic<int> look_count{0};
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

storage::OperationRecord Ingest(OneServer& server, const std::string& clip, double phase) {
  const auto live = Require(server.engine->FindDatabase("d"));
  const auto in_flight = Require(server.engine->BeginIngest(live));
  storage::NewClip request;
  request.record.file_name = clip + ".bvh";
  request.file_bytes = WriteBvh(Walk(phase));
  return Require(server.engine->Ingest(live, {std::move(request)}, {})).operation;
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
  Ingest(b, "walk", 0.2);
  Await([&] { return Serves(b, 2); });
  a.is_stopped = false;
  a.model_gate->Open();
  Await([&] { return Serves(a, 2); });
  CHECK(VersionOf(a) == VersionOf(b));
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

TEST_CASE("Engines on one store: only servers that build do so", "[server][servers]") {
  const auto store = NewStore();
  auto options = TestEngine::QuickOptions();
  options.builds = false;
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
