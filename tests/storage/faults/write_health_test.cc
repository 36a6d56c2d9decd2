// A store on a failing disk reports and counts the failures, and detects when the disk works again.
#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "tests/storage/faults/fault_disk.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_file.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests::write_health_test {
namespace {

using Fault = FaultDisk::Fault;

// Waits until CheckWrites succeeds. It tries a write at most once a second.
void AwaitWrites(storage::MotionStore& store) {
  const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!store.CheckWrites().ok()) {
    REQUIRE(std::chrono::steady_clock::now() < latest);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

}  // namespace

TEST_CASE("WriteHealth: a failing disk, and recovery without a write of a caller",
          "[storage][fault]") {
  const TemporaryDirectory folder;
  FaultDisk disk;
  const auto store =
      Require(storage::SqliteMotionStore::Open(folder / "store.db", {.vfs = FaultDisk::kVfs}));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store->CheckWrites());

  // A single write fails: the test write shows that writes work again.
  disk.Arm(Fault::kError, 1);
  REQUIRE_ERROR(store->AddClip(SampleClip("d", "walk", 1)), absl::StatusCode::kUnavailable, "");
  CHECK(store->write_failures().io_error == 1);
  AwaitWrites(*store);

  disk.Arm(Fault::kFull, 1);
  REQUIRE_ERROR(store->AddClip(SampleClip("d", "walk", 1)), absl::StatusCode::kResourceExhausted,
                "full");
  CHECK(store->write_failures().no_space == 1);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  REQUIRE_ERROR(store->CheckWrites(), absl::StatusCode::kResourceExhausted, "full");
  disk.Clear();
  AwaitWrites(*store);
  // Test writes are not counted.
  CHECK(store->write_failures().total() == 2);
  REQUIRE_OK(store->AddClip(SampleClip("d", "walk", 1)));
}

}  // namespace motiondb::tests::write_health_test
