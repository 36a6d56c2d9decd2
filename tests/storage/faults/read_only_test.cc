// A store that is open read-only: everything can be read, changes fail, no file is written.
#include <sys/mount.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <set>
#include <string>

#include "absl/cleanup/cleanup.h"
#include "storage/sqlite/schema.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::read_only_test {
namespace {

using absl::StatusCode;

storage::SqliteOptions ReadOnly() { return {.read_only = true}; }

void Fill(storage::SqliteMotionStore& store) {
  REQUIRE_OK(store.CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store.AddClip(SampleClip("d", "walk", 1)));
  REQUIRE_OK(store.PutModel("d", SampleModel({SampleClip("d", "walk", 1)})));
}

// Requires that every kind of change is refused.
void RequireUnchangeable(storage::SqliteMotionStore& store) {
  constexpr char kWhy[] = "restart motiondbd without --read-only";
  constexpr auto kCode = StatusCode::kFailedPrecondition;
  REQUIRE_ERROR(store.maintenance().CheckIsWritable(), kCode, kWhy);
  REQUIRE_ERROR(store.CreateDatabase(SampleDatabase("e")), kCode, kWhy);
  REQUIRE_ERROR(store.DeleteDatabase("d"), kCode, kWhy);
  REQUIRE_ERROR(store.AddClip(SampleClip("d", "run", 2)), kCode, kWhy);
  REQUIRE_ERROR(store.DeleteClip("d", "walk"), kCode, kWhy);
  REQUIRE_ERROR(store.PutOperation(SampleOperation("d", "op")), kCode, kWhy);
  REQUIRE_ERROR(store.DropModel("d"), kCode, kWhy);
  REQUIRE_ERROR(store.access().AddToken({.id = "t"}), kCode, kWhy);
  REQUIRE_ERROR(store.maintenance().BeginRestore(), kCode, kWhy);
  REQUIRE_ERROR(store.maintenance().BeginImport(), kCode, kWhy);
  REQUIRE_OK(store.maintenance().CheckFile());
}

// Returns the names and sizes of all files in a folder.
std::string Files(const std::filesystem::path& folder) {
  std::set<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    files.insert(entry.path().filename().string() + " " + std::to_string(entry.file_size()) + "\n");
  }
  std::string text;
  for (const std::string& file : files) text += file;
  return text;
}

}  // namespace

TEST_CASE("SqliteMotionStore: read-only, everything can be read and nothing is written",
          "[storage][read_only]") {
  const StoreFile file;
  std::string before;
  const bool has_log = GENERATE(false, true);
  if (has_log) {
    const StoreFile running;
    const auto store = running.Open();
    Fill(*store);
    before = Dump(*store);
    for (const char* const suffix : {"", "-wal", "-lock"}) {
      std::filesystem::copy_file(running.path() + suffix, file.path() + suffix);
    }
  } else {
    const auto store = file.Open();
    Fill(*store);
    before = Dump(*store);
  }
  std::filesystem::resize_file(file.path() + "-lock", 0);
  const std::string files = Files(file.folder());
  {
    const auto store = file.Open(ReadOnly());
    REQUIRE(Dump(*store) == before);
    REQUIRE(Findings(*store).empty());
    RequireUnchangeable(*store);
    REQUIRE(Dump(*store) == before);
    // It can be opened read-only again, but not for writing.
    REQUIRE(Dump(*file.Open(ReadOnly())) == before);
    REQUIRE_ERROR(file.TryOpen(), StatusCode::kFailedPrecondition, "in use");
  }
  REQUIRE(Files(file.folder()) == files);
  const auto store = file.Open();
  REQUIRE_ERROR(file.TryOpen(ReadOnly()), StatusCode::kFailedPrecondition, "in use (process ");
  REQUIRE(Dump(*store) == before);
}

TEST_CASE("SqliteMotionStore: a read-only file system, with and without a log",
          "[storage][read_only]") {
  const StoreFile source;
  const std::filesystem::path disk = source.folder() / "disk";
  std::filesystem::create_directory(disk);
  if (mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=8m") != 0) {
    WARN("skipped: cannot mount a tmpfs: " << std::strerror(errno));
    return;
  }
  const absl::Cleanup unmount = [&] { umount(disk.c_str()); };
  std::string before;
  {
    const auto store = source.Open();
    Fill(*store);
    before = Dump(*store);
    std::filesystem::copy_file(source.path(), disk / "killed.db");
    std::filesystem::copy_file(source.path() + "-wal", disk / "killed.db-wal");
  }
  std::filesystem::copy_file(source.path(), disk / "50%25?mode=rw#1 .db");
  REQUIRE(mount("tmpfs", disk.c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, "") == 0);
  for (const char* const name : {"killed.db", "50%25?mode=rw#1 .db"}) {
    CAPTURE(name);
    const std::string path = (disk / name).string();
    REQUIRE_ERROR(storage::SqliteMotionStore::Open(path), StatusCode::kUnavailable, "Read-only");
    const auto store = Require(storage::SqliteMotionStore::Open(path, ReadOnly()));
    REQUIRE(Dump(*store) == before);
    REQUIRE(Findings(*store).empty());
    RequireUnchangeable(*store);
  }
}

TEST_CASE("SqliteMotionStore: read-only, the store must exist and have the current version",
          "[storage][read_only]") {
  const StoreFile file;
  REQUIRE_ERROR(file.TryOpen(ReadOnly()), StatusCode::kUnavailable, "gone");
  REQUIRE(std::filesystem::is_empty(file.folder()));
  file.Open();
  file.Sql("PRAGMA user_version = 1");
  REQUIRE_ERROR(file.TryOpen(ReadOnly()), StatusCode::kFailedPrecondition,
                "version 1; expected " + std::to_string(storage::Migrations().size()));
  REQUIRE_ERROR(storage::SqliteMotionStore::Open(":memory:", ReadOnly()),
                StatusCode::kInvalidArgument, "memory");
}

}  // namespace motiondb::tests::read_only_test
