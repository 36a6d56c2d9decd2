// A file system without room, a real one: a small tmpfs, where a test may mount it.
#include <sys/mount.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests {
namespace {

constexpr std::size_t kMegabyte = std::size_t{1} << 20;

class SmallFileSystem {
 public:
  SmallFileSystem() : path_(folder_ / "small") {
    std::filesystem::create_directory(path_);
    mounted_ = mount("tmpfs", path_.c_str(), "tmpfs", 0, "size=6m") == 0;
    error_ = errno;
  }
  ~SmallFileSystem() {
    if (mounted_) umount(path_.c_str());
  }
  // Makes it larger, with all that is in it.
  bool Grow() { return mount("tmpfs", path_.c_str(), "tmpfs", MS_REMOUNT, "size=40m") == 0; }
  bool mounted() const { return mounted_; }
  std::string error() const { return std::strerror(error_); }
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  TemporaryDirectory folder_;
  const std::string path_;
  bool mounted_ = false;
  int error_ = 0;
};

}  // namespace

TEST_CASE("SqliteMotionStore: a file system without room", "[storage][full]") {
  SmallFileSystem disk;
  if (!disk.mounted()) {
    WARN("skipped: a tmpfs cannot be mounted here: " << disk.error());
    return;
  }
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
  // Others fill the rest: the store can be opened and read, and says why it takes nothing.
  std::ofstream filler(disk / "filler", std::ios::binary);
  for (const std::string block(4096, 'x'); filler.write(block.data(), 4096).flush();) {
  }
  filler.close();
  {
    const auto store = Require(storage::SqliteMotionStore::Open(path));
    REQUIRE(Dump(*store) == before);
    // What room is left in the log is used up first.
    absl::Status added;
    for (unsigned seed = 3; seed < 300 && added.ok(); ++seed) {
      before = Dump(*store);
      added = store->AddClip(SampleClip("d", "run", seed)).status();
    }
    REQUIRE_ERROR(added, absl::StatusCode::kResourceExhausted, "full");
    REQUIRE(Dump(*store) == before);
    REQUIRE_ERROR(store->upkeep().BeginBackup({}), absl::StatusCode::kResourceExhausted, "full");
    REQUIRE(disk.Grow());
    REQUIRE_OK(store->AddClip(SampleClip("d", "last", 1000)));
    REQUIRE(Findings(*store).empty());
  }
  const auto store = Require(storage::SqliteMotionStore::Open(path));
  REQUIRE_OK(store->GetClip("d", "last"));
  REQUIRE(Findings(*store).empty());
}

}  // namespace motiondb::tests
