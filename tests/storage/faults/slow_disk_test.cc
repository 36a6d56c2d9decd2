// Verification of a large store on a slow disk.
#include <catch2/catch.hpp>

#include "tests/storage/faults/fault_disk.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::slow_disk_test {

TEST_CASE("Slow disk: the check of the file's pages stops soon after cancellation",
          "[storage][verify]") {
  constexpr int kPages = 2000;
  const StoreFile file;
  {
    const auto store = file.Open();
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
    auto clip = SampleClip("d", "large", 1);
    clip.file_bytes.assign(kPages * 16384, 'x');
    REQUIRE_OK(store->AddClip(clip));
  }
  FaultDisk disk;
  const auto store = file.Open({.reader_count = 1, .now_us = {}, .vfs = FaultDisk::kVfs});
  const int before = disk.reads();
  disk.SlowDown();
  const auto verifier =
      Require(store->maintenance().BeginVerify([&] { return disk.reads() > before + 100; }));
  std::vector<storage::Corruption> found;
  REQUIRE(Require(verifier->Step(found)));  // the schema, a few pages
  REQUIRE_ERROR(verifier->Step(found), absl::StatusCode::kCancelled, "cancelled");
  REQUIRE(found.empty());
  REQUIRE(disk.reads() < before + kPages / 2);
}

}  // namespace motiondb::tests::slow_disk_test
