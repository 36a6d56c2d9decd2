// The life of a database: concurrent changes, exclusive deletion.
#include "server/engine/live_database.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <memory>
#include <new>
#include <thread>
#include <vector>

namespace motiondb::tests::live_database_test {
namespace {

using server::DeletionPolicy;
using server::LiveDatabase;

const auto kNothing = [] { return absl::OkStatus(); };

TEST_CASE("LiveDatabase: continuous changes do not starve the deletion", "[server]") {
  LiveDatabase database("db", {});
  std::atomic<int> changes = 0;
  std::atomic<int> ended = 0;
  // Each thread starts its next change while another thread runs one.
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] {
      const auto retiring = i % 2 == 0 ? DeletionPolicy::kAwait : DeletionPolicy::kRefuse;
      absl::Status status;
      while (status.ok() || absl::IsUnavailable(status)) {
        status = database.WithSharedUse(retiring, [&] {
          ++changes;
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
          --changes;
          return absl::OkStatus();
        });
      }
      if (absl::IsNotFound(status)) ++ended;
    });
  }
  while (changes < 2) std::this_thread::yield();
  int changes_during_deletion = -1;
  absl::Status refused;
  const absl::Status deleted = database.Retire([&] {
    changes_during_deletion = changes;
    refused = database.WithSharedUse(DeletionPolicy::kRefuse, kNothing);
    return absl::OkStatus();
  });
  for (std::thread& thread : threads) thread.join();
  CHECK(deleted.ok());
  CHECK(changes_during_deletion == 0);
  CHECK(absl::IsUnavailable(refused));
  CHECK(ended == 4);
  CHECK(absl::IsNotFound(database.Retire(kNothing)));
}

TEST_CASE("ChangeSignal: a listener is not part of work whose allocations may fail", "[server]") {
  const auto signal = std::make_shared<server::ChangeSignal>();
  bool may_fail = true;
  const auto subscription =
      signal->Subscribe([&] { may_fail = storage::AllocationsMayFail::hold(); });
  const storage::AllocationsMayFail scope;
  signal->Notify();
  CHECK_FALSE(may_fail);
  CHECK(storage::AllocationsMayFail::hold());
}

TEST_CASE("LiveDatabase: stays alive if its deletion fails or is cancelled", "[server]") {
  LiveDatabase database("db", {});
  absl::Status late;
  CHECK(database
            .WithSharedUse(DeletionPolicy::kRefuse,
                           [&] {
                             late = database.Retire(kNothing, [] { return true; });
                             return absl::OkStatus();
                           })
            .ok());
  CHECK(absl::IsCancelled(late));
  CHECK(absl::IsResourceExhausted(
      database.Retire([] { return absl::ResourceExhaustedError("disk"); })));
  CHECK_THROWS(database.Retire([]() -> absl::Status { throw std::bad_alloc(); }));
  CHECK_THROWS(database.WithSharedUse(DeletionPolicy::kAwait,
                                      []() -> absl::Status { throw std::bad_alloc(); }));
  CHECK(database.WithSharedUse(DeletionPolicy::kAwait, kNothing).ok());
  CHECK(database.Retire(kNothing).ok());
  CHECK(absl::IsNotFound(database.WithSharedUse(DeletionPolicy::kAwait, kNothing)));
}

}  // namespace
}  // namespace motiondb::tests::live_database_test
