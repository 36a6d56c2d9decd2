// The file or the log of an open store is moved away or replaced: reads still work, and no change
// is acknowledged that would be lost.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/storage/backup_bytes.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::lost_file_test {
namespace {

using absl::StatusCode;

class LosableStore {
 public:
  storage::SqliteMotionStore& operator*() const { return *store_; }
  storage::SqliteMotionStore* operator->() const { return store_.get(); }
  const StoreFile& file() const { return file_; }

  // Moves a file away. `suffix`: "" for the store's file, "-wal" for its log.
  void TakeAway(const std::string& suffix = "") const {
    std::filesystem::rename(file_.path() + suffix, aside());
  }
  // Replaces a file by a copy of itself, the replacement that is hardest to detect.
  void Replace(const std::string& suffix = "") const {
    TakeAway(suffix);
    std::filesystem::copy_file(aside(), file_.path() + suffix);
  }
  void PutBack(const std::string& suffix = "") const {
    std::filesystem::rename(aside(), file_.path() + suffix);
  }

 private:
  std::filesystem::path aside() const { return file_.folder() / "aside.db"; }

  const StoreFile file_;
  const std::unique_ptr<storage::SqliteMotionStore> store_ = file_.Open();
};

// Requires that every kind of change is refused.
void RequireUnchangeable(storage::SqliteMotionStore& store, const std::string& why) {
  REQUIRE_ERROR(store.maintenance().CheckFile(), StatusCode::kUnavailable, why);
  REQUIRE_ERROR(store.CreateDatabase(SampleDatabase("e")), StatusCode::kUnavailable, why);
  REQUIRE_ERROR(store.DeleteDatabase("d"), StatusCode::kUnavailable, why);
  REQUIRE_ERROR(store.AddClip(SampleClip("d", "run", 2)), StatusCode::kUnavailable, why);
  REQUIRE_ERROR(store.DeleteClip("d", "walk"), StatusCode::kUnavailable, why);
  REQUIRE_ERROR(store.PutOperation(SampleOperation("d", "op")), StatusCode::kUnavailable, why);
  REQUIRE_ERROR(store.access().AddToken({.id = "t"}), StatusCode::kUnavailable, why);
}

}  // namespace

TEST_CASE("SqliteMotionStore: without its file, changes are refused until it is back",
          "[storage][lost]") {
  const LosableStore store;
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store->AddClip(SampleClip("d", "walk", 1)));
  const std::string before = Dump(*store);
  const std::string path = store.file().path();
  REQUIRE_OK(store->maintenance().CheckFile());
  std::string why = "the store's file '" + path + "' ";
  SECTION("taken away") {
    store.TakeAway();
    why += "is gone (No such file or directory): changes are refused";
  }
  SECTION("replaced") {
    store.Replace();
    why += "was replaced by another file: changes are refused";
  }
  RequireUnchangeable(*store, why);
  REQUIRE(Dump(*store) == before);
  store.PutBack();
  REQUIRE_OK(store->maintenance().CheckFile());
  REQUIRE_OK(store->AddClip(SampleClip("d", "run", 2)));
  REQUIRE(Findings(*store).empty());
}

TEST_CASE("SqliteMotionStore: without its log, changes are refused and the log's content is saved",
          "[storage][lost]") {
  const LosableStore store;
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store->AddClip(SampleClip("d", "walk", 1)));
  const std::string before = Dump(*store);
  std::string why = "the store's log '" + store.file().path() + "-wal' ";
  SECTION("taken away") {
    store.TakeAway("-wal");
    why += "is gone (No such file or directory): changes are refused";
  }
  SECTION("replaced") {
    store.Replace("-wal");
    why += "was replaced by another file: changes are refused";
  }
  RequireUnchangeable(*store, why);
  REQUIRE(Dump(*store) == before);
  // After a kill only the store's file remains: it contains everything.
  const StoreFile killed;
  std::filesystem::copy_file(store.file().path(), killed.path());
  REQUIRE(Dump(*killed.Open()) == before);
  store.PutBack("-wal");
  REQUIRE_OK(store->AddClip(SampleClip("d", "run", 2)));
  REQUIRE(Findings(*store).empty());
}

TEST_CASE("SqliteMotionStore: closed without its log, it has all acknowledged changes",
          "[storage][lost]") {
  const StoreFile file;
  {
    const auto store = file.Open();
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
    std::filesystem::remove(file.path() + "-wal");
  }
  REQUIRE_OK(file.Open()->GetDatabase("d"));
}

TEST_CASE("SqliteMotionStore: no connection is opened to a file that replaced the store",
          "[storage][lost]") {
  const LosableStore store;
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  store.Replace();  // before the first read
  REQUIRE_ERROR(store->ListDatabases({}), StatusCode::kUnavailable, "was replaced by another file");
  store.PutBack();
  REQUIRE(Require(store->ListDatabases({})).size() == 1);
}

TEST_CASE("Restore: fails if the file of the store is missing", "[storage][lost]") {
  const LosableStore source;
  REQUIRE_OK(source->CreateDatabase(SampleDatabase("d")));
  const std::string bytes = Backup(*source);
  const LosableStore target;
  const auto restore = Require(target->maintenance().BeginRestore());
  REQUIRE_OK(restore->Append(bytes));
  REQUIRE_OK(restore->Check({}));
  target.TakeAway();
  REQUIRE_ERROR(restore->Finish({}), StatusCode::kUnavailable, "gone");
  target.PutBack();
  REQUIRE(Require(target->ListDatabases({})).empty());
  REQUIRE_OK(Restore(*target, bytes));
}

TEST_CASE("SqliteMotionStore: a store in memory has no file to lose", "[storage][lost]") {
  const auto store = Require(storage::SqliteMotionStore::Open(":memory:"));
  REQUIRE_OK(store->maintenance().CheckFile());
}

}  // namespace motiondb::tests::lost_file_test
