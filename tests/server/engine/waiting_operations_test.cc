// The queue of a ModelLifecycle with operations of other servers, in simulated time.
#include <spdlog/spdlog.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "server/engine/corruption_log.h"
#include "server/engine/live_database.h"
#include "server/engine/model_lifecycle.h"
#include "server/engine/work/operation_registry.h"
#include "server/engine/work/options.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/storage/require_ok.h"
#include "tests/support/gated_store.h"
#include "tests/support/simulated_executor.h"

namespace motiondb::tests::waiting_operations_test {
namespace {

using std::chrono::seconds;
using storage::OperationState;

// A server with an empty database.
struct OneDatabase {
  OneDatabase() {
    spdlog::set_level(spdlog::level::off);
    REQUIRE_OK(store.CreateDatabase({.name = "d"}));
    live->set_id(Require(store.GetDatabase("d")).id);
    live->Serve(std::make_unique<server::ModelLifecycle>(
        *live,
        server::LifecycleServices{store, operations, corruptions, executor, options, "one"}));
  }

  // As the engine does after each look at the store.
  void Follow() {
    const auto unfinished = Require(store.ListUnfinishedOperations());
    operations.Follow(unfinished);
    std::vector<std::string> ids;
    for (const auto& operation : unfinished) ids.push_back(operation.id);
    live->lifecycle().Follow(ids, /*is_changed=*/false);
  }
  OperationState StateOf(const std::string& operation) {
    return Require(store.GetOperation(operation)).state;
  }

  SharedStore store{Require(storage::SqliteMotionStore::Open(":memory:")),
                    std::make_shared<Gate>()};
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

}  // namespace motiondb::tests::waiting_operations_test
