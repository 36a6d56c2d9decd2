// The queue of a ModelLifecycle with operations of other servers, in simulated time.
#include <spdlog/spdlog.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "server/engine/live_database.h"
#include "server/engine/model_lifecycle.h"
#include "server/engine/operator_log.h"
#include "server/engine/work/engine_options.h"
#include "server/engine/work/operation_registry.h"
#include "storage/blob/newer_format.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/storage/require_ok.h"
#include "tests/support/gated_store.h"
#include "tests/support/simulated_executor.h"

namespace motiondb::tests::waiting_operations_test {
namespace {

using std::chrono::seconds;
using storage::OperationState;

// Access to a store that a newer server may have written to.
class NewerStore final : public SharedStore {
 public:
  using SharedStore::SharedStore;
  absl::StatusOr<std::int64_t> AcquireBuildLease(const std::string& database,
                                                 const std::string& holder,
                                                 std::chrono::milliseconds duration) override {
    ++build_count;
    return SharedStore::AcquireBuildLease(database, holder, duration);
  }
  absl::StatusOr<storage::ModelStaleness> FindModelStaleness(const std::string& database) override {
    if (is_newer) return storage::NewerFormat("model");
    return SharedStore::FindModelStaleness(database);
  }

  bool is_newer = false;
  int build_count = 0;
};

// A server with an empty database.
struct OneDatabase {
  OneDatabase() {
    spdlog::set_level(spdlog::level::off);
    REQUIRE_OK(store.CreateDatabase({.name = "d"}));
    live->set_id(Require(store.GetDatabase("d")).id);
    live->SetLifecycle(std::make_unique<server::ModelLifecycle>(
        *live,
        server::LifecycleServices{store, operations, corruptions, executor, options, "one"}));
  }

  // As the engine does after each look at the store.
  void Follow(bool is_changed = false) {
    const auto unfinished = Require(store.ListUnfinishedOperations());
    operations.Follow(unfinished);
    std::vector<std::string> ids;
    for (const auto& operation : unfinished) ids.push_back(operation.id);
    live->lifecycle().Follow(ids, is_changed);
  }
  // Looks each second.
  void Run(seconds time) {
    for (seconds passed{0}; passed < time; passed += seconds(1)) {
      executor.RunUntil(executor.Now() + seconds(1));
      Follow();
    }
  }
  OperationState StateOf(const std::string& operation) {
    return Require(store.GetOperation(operation)).state;
  }

  NewerStore store{Require(storage::SqliteMotionStore::Open(":memory:")), std::make_shared<Gate>()};
  server::OperationRegistry operations{store};
  server::OperationRegistry of_another_server{store};
  server::CorruptionLog corruptions;
  SimulatedExecutor executor{1};
  server::EngineOptions options;
  std::shared_ptr<server::LiveDatabase> live =
      std::make_shared<server::LiveDatabase>("d", core::BuildSettings());
};

}  // namespace

TEST_CASE("Lifecycle: an operation of another server runs after the own one was ended there",
          "[server][servers]") {
  OneDatabase server;
  const auto own = Require(server.live->lifecycle().Request());
  const auto other = Require(server.of_another_server.Create("d"));
  server.Follow();
  CHECK(Require(server.of_another_server.CancelAnywhere(own.id)));
  server.Follow();
  CHECK(server.live->lifecycle().operation() == other.id);
  server.executor.RunUntil(server.executor.Now() + seconds(1));
  CHECK(server.StateOf(other.id) == OperationState::kPending);  // its server comes first
  server.executor.RunUntil(server.executor.Now() + seconds(10));
  CHECK(server.StateOf(other.id) == OperationState::kSucceeded);
  CHECK(server.StateOf(own.id) == OperationState::kCancelled);
}

TEST_CASE("Lifecycle: what a newer server has stored is tried again after a change, or a minute",
          "[server][servers]") {
  OneDatabase server;
  server.store.is_newer = true;
  const auto operation = Require(server.live->lifecycle().Request());
  server.Run(seconds(30));
  CHECK(server.store.build_count == 1);
  server.Follow(/*is_changed=*/true);
  server.Run(seconds(5));
  CHECK(server.store.build_count == 2);
  CHECK(Require(server.live->lifecycle().Request()).id == operation.id);
  server.Run(seconds(50));
  CHECK(server.store.build_count == 2);
  CHECK(server.StateOf(operation.id) == OperationState::kPending);
  server.store.is_newer = false;
  server.Run(seconds(20));
  CHECK(server.StateOf(operation.id) == OperationState::kSucceeded);
}

}  // namespace motiondb::tests::waiting_operations_test
