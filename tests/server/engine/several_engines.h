// Several engines on one store, as several servers on one PostgreSQL.
#pragma once

#include <spdlog/spdlog.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <memory>
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

namespace motiondb::tests {

using std::chrono::seconds;
using storage::OperationState;

// What a test controls and sees of the access of a server to the store.
struct Access {
  std::atomic<bool> is_stopped{false};  // leases are not renewed, nothing is looked at or purged
  std::atomic<bool> is_old{false};      // stored models are of a newer version
  storage::OnStoreChange on_change;     // what a notification calls
  std::function<void()> after_read;     // called when the first model was read
  std::function<void()> around_add;     // called before and after each clip is stored
  std::shared_ptr<Gate> model_gate = std::make_shared<Gate>();   // closed: models are not stored
  std::shared_ptr<Gate> derive_gate = std::make_shared<Gate>();  // closed: nor derived clips
  std::atomic<int> look_count{0};
  std::atomic<int> failed_look_count{0};
  std::atomic<int> postponed_build_count{0};  // builds that began and were given up until later
  std::atomic<int> purge_count{0};
};

class WatchedStore final : public SharedStore {
 public:
  WatchedStore(std::shared_ptr<storage::MotionStore> store, Access& access)
      : SharedStore(std::move(store), std::make_shared<Gate>(), access.model_gate,
                    std::make_shared<SimulatedDisk>(), std::make_shared<Gate>(),
                    access.derive_gate),
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
    if (access_.is_stopped) {
      ++access_.failed_look_count;
      return absl::UnavailableError("the store is cut off");
    }
    ++access_.look_count;
    return GatedStore::ListDatabaseStates();
  }
  absl::Status PutOperation(const storage::OperationRecord& record,
                            const core::Cancelled& cancelled) override {
    const auto before = GatedStore::GetOperation(record.id);
    absl::Status stored = GatedStore::PutOperation(record, cancelled);
    const bool was_running = before.ok() && before->state == OperationState::kRunning;
    if (stored.ok() && was_running && record.state == OperationState::kPending) {
      ++access_.postponed_build_count;
    }
    return stored;
  }
  absl::StatusOr<storage::ClipRecord> AddClip(const storage::NewClip& clip) override {
    if (access_.around_add) access_.around_add();
    auto added = GatedStore::AddClip(clip);
    if (access_.around_add) access_.around_add();
    return added;
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
    engine = Require(server::Engine::Open(std::make_unique<WatchedStore>(store, *this), options));
  }
  ~OneServer() {
    model_gate->Open();
    derive_gate->Open();
  }

  std::unique_ptr<server::Engine> engine;
};

inline std::shared_ptr<storage::MotionStore> NewStore() {
  spdlog::set_level(spdlog::level::off);
  return Require(storage::SqliteMotionStore::Open(":memory:"));
}

inline void Create(OneServer& server, const std::string& name) {
  REQUIRE_OK(server.engine->CreateDatabase(name, {.frame_rate_hz = 60, .min_frames = 4},
                                           {server::kSourceMarkerSet, ""}));
}

inline absl::StatusOr<server::Ingested> TryIngest(OneServer& server, const std::string& clip,
                                                  double phase) {
  const auto live = Require(server.engine->FindDatabase("d"));
  const auto in_flight = Require(server.engine->BeginIngest(live));
  storage::NewClip request;
  request.record.file_name = clip + ".bvh";
  request.file_bytes = WriteBvh(Walk(phase));
  return server.engine->Ingest(live, {std::move(request)}, {});
}

inline storage::OperationRecord Ingest(OneServer& server, const std::string& clip, double phase) {
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

inline bool Serves(OneServer& server, int clips) {
  server.engine->LookNow();
  const auto live = server.engine->FindDatabase("d");
  if (!live.ok()) return false;
  const auto snapshot = (*live)->lifecycle().snapshot();
  return snapshot != nullptr && snapshot->is_stored() && snapshot->record.clip_count == clips;
}

inline OperationState StateOf(OneServer& server, const std::string& operation) {
  return Require(server.engine->operations().Get(operation)).state;
}

inline server::LeaseTally LeasesOf(OneServer& server) {
  return Require(server.engine->FindDatabase("d"))->lifecycle().leases();
}

// Creates the database `d` with one clip, waits until it is built and nothing is left to do, and
// returns the id of the clip.
inline std::string BuildOneClip(OneServer& server, storage::MotionStore& store) {
  Create(server, "d");
  Ingest(server, "walk", 0.1);
  Await([&] { return Serves(server, 1); });
  Await([&] { return store.ListUnfinishedOperations()->empty(); });
  return Require(store.ListClips("d", {.after = "", .limit = 1}))[0].id;
}

inline int VersionOf(OneServer& server) {
  return Require(server.engine->FindDatabase("d"))->lifecycle().snapshot()->record.version;
}

}  // namespace motiondb::tests
