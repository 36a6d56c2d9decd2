// A real full file system: a small tmpfs, if the test has the right to mount it.
#include <sys/mount.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "storage/sqlite/store_file.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests::full_disk_test {
namespace {

constexpr std::size_t kMegabyte = std::size_t{1} << 20;

class SmallFileSystem {
 public:
  explicit SmallFileSystem(int mebibytes) : path_(folder_ / "small") {
    std::filesystem::create_directory(path_);
    const std::string size = "size=" + std::to_string(mebibytes) + "m";
    mounted_ = mount("tmpfs", path_.c_str(), "tmpfs", 0, size.c_str()) == 0;
    error_ = errno;
  }
  ~SmallFileSystem() {
    if (mounted_) umount(path_.c_str());
  }
  // Enlarges the mounted file system.
  bool Grow() { return mount("tmpfs", path_.c_str(), "tmpfs", MS_REMOUNT, "size=40m") == 0; }
  // Returns whether it is mounted; warns that the test is skipped if not.
  bool IsThere() const {
    if (!mounted_) WARN("skipped: cannot mount a tmpfs: " << std::strerror(error_));
    return mounted_;
  }
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  TemporaryDirectory folder_;
  const std::string path_;
  bool mounted_ = false;
  int error_ = 0;
};

// Returns a clip of a little more than 1 MiB.
storage::NewClip LargeClip(unsigned seed) {
  auto clip = SampleClip("d", "large-" + std::to_string(seed), seed);
  clip.file_bytes.assign(kMegabyte, 'x');
  return clip;
}

// Adds clips until there is no room. Returns the number of added clips.
int Fill(storage::MotionStore& store, unsigned first_seed) {
  for (int count = 0;; ++count) {
    const auto added = store.AddClip(LargeClip(first_seed + static_cast<unsigned>(count)));
    if (added.ok()) continue;
    REQUIRE_ERROR(added, absl::StatusCode::kResourceExhausted, "--disk-reserve-mib");
    return count;
  }
}

storage::SqliteOptions WithReserve(std::size_t mebibytes) {
  return {.reserve_bytes = static_cast<std::int64_t>(mebibytes * kMegabyte)};
}

}  // namespace

TEST_CASE("SqliteMotionStore: clips can be deleted after the disk was filled up to the reserve",
          "[storage][full]") {
  const SmallFileSystem disk(32);
  if (!disk.IsThere()) return;
  const std::string path = disk / "store.db";
  int count = 0;
  {
    const auto store = Require(storage::SqliteMotionStore::Open(path, WithReserve(8)));
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
    count = Fill(*store, 1);
    CHECK(count >= 12);
    REQUIRE_OK(store->DeleteClip("d", "large-1"));
  }
  {
    const auto store = Require(storage::SqliteMotionStore::Open(path, WithReserve(8)));
    for (int i = 2; i <= 4; ++i) {
      REQUIRE_OK(store->DeleteClip("d", "large-" + std::to_string(i)));
    }
    // The freed pages are reused, although the disk has no more free space than before.
    CHECK(Fill(*store, 100) >= 3);
    REQUIRE_OK(store->DeleteDatabase("d"));
    REQUIRE_OK(store->PurgeDeletedDatabases({}));
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
    CHECK(Fill(*store, 200) >= count - 1);
    REQUIRE(Findings(*store).empty());
  }
}

TEST_CASE("SqliteMotionStore: CheckWrites reports a full disk until there is room",
          "[storage][full]") {
  const SmallFileSystem disk(32);
  if (!disk.IsThere()) return;
  const auto store = Require(storage::SqliteMotionStore::Open(disk / "store.db", WithReserve(8)));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store->AddClip(LargeClip(1)));
  REQUIRE_OK(store->CheckWrites());
  CHECK(store->write_failures().total() == 0);
  // Another file fills the disk: no write has failed yet.
  std::ofstream(disk / "other", std::ios::binary) << std::string(24 * kMegabyte, 'x');
  REQUIRE_ERROR(store->CheckWrites(), absl::StatusCode::kResourceExhausted, "--disk-reserve-mib");
  REQUIRE_ERROR(store->AddClip(LargeClip(2)), absl::StatusCode::kResourceExhausted, "");
  REQUIRE_ERROR(store->CheckWrites(), absl::StatusCode::kResourceExhausted, "--disk-reserve-mib");
  CHECK(store->write_failures().no_space == 1);
  CHECK(store->write_failures().total() == 1);
  REQUIRE_OK(store->DeleteClip("d", "large-1"));
  std::filesystem::remove(disk / "other");
  // The next test write, within a second, succeeds.
  const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!store->CheckWrites().ok()) {
    REQUIRE(std::chrono::steady_clock::now() < latest);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  REQUIRE_OK(store->AddClip(LargeClip(2)));
  CHECK(store->write_failures().total() == 1);
  // Errors of the request are not failed writes.
  REQUIRE(!store->DeleteClip("d", "none").ok());
  REQUIRE(!store->CreateDatabase(SampleDatabase("d")).ok());
  CHECK(store->write_failures().total() == 1);
  REQUIRE(Findings(*store).empty());
}

TEST_CASE("SqliteMotionStore: a reader that blocks the log blocks additions only while it reads",
          "[storage][full]") {
  const SmallFileSystem disk(32);
  if (!disk.IsThere()) return;
  const std::string path = disk / "store.db";
  const auto store = Require(storage::SqliteMotionStore::Open(path, WithReserve(8)));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  const auto reader = Require(storage::OpenReader(path, ""));
  REQUIRE_OK(reader->Execute("BEGIN; SELECT count(*) FROM clip"));
  CHECK(Fill(*store, 1) >= 4);
  REQUIRE_OK(store->DeleteClip("d", "large-1"));
  REQUIRE_OK(reader->Execute("COMMIT"));
  CHECK(Fill(*store, 100) >= 2);
  REQUIRE_OK(store->DeleteDatabase("d"));
}

TEST_CASE("SqliteMotionStore: a full file system", "[storage][full]") {
  SmallFileSystem disk(6);
  if (!disk.IsThere()) return;
  const std::string path = disk / "store.db";
  std::string before;
  {
    const auto store = Require(storage::SqliteMotionStore::Open(path));
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
    REQUIRE_OK(store->AddClip(SampleClip("d", "walk", 1)));
    before = Dump(*store);
    auto large = SampleClip("d", "large", 2);
    large.file_bytes.assign(8 * kMegabyte, 'x');
    for (int i = 0; i < 3; ++i) {
      REQUIRE_ERROR(store->AddClip(large), absl::StatusCode::kResourceExhausted, "full");
      REQUIRE(Dump(*store) == before);
    }
  }
  // Another file fills the rest: the store can be opened and read; additions return the reason.
  std::ofstream filler(disk / "filler", std::ios::binary);
  for (const std::string block(4096, 'x'); filler.write(block.data(), 4096).flush();) {
  }
  filler.close();
  {
    const auto store = Require(storage::SqliteMotionStore::Open(path));
    REQUIRE(Dump(*store) == before);
    // The remaining room in the log is used first.
    absl::Status added;
    for (unsigned seed = 3; seed < 300 && added.ok(); ++seed) {
      before = Dump(*store);
      added = store->AddClip(SampleClip("d", "run", seed)).status();
    }
    REQUIRE_ERROR(added, absl::StatusCode::kResourceExhausted, "full");
    REQUIRE(Dump(*store) == before);
    REQUIRE_ERROR(store->maintenance().BeginBackup({}), absl::StatusCode::kResourceExhausted,
                  "full");
    REQUIRE(disk.Grow());
    REQUIRE_OK(store->AddClip(SampleClip("d", "last", 1000)));
    REQUIRE(Findings(*store).empty());
  }
  const auto store = Require(storage::SqliteMotionStore::Open(path));
  REQUIRE_OK(store->GetClip("d", "last"));
  REQUIRE(Findings(*store).empty());
}

}  // namespace motiondb::tests::full_disk_test
