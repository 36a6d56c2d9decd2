// A backup is a moment of a running store, and comes back as that or not at all.
#include "storage/sqlite/sqlite_backup.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <thread>

#include "storage/sqlite/schema.h"
#include "tests/storage/backup_bytes.h"
#include "tests/storage/damaged_store.h"
#include "tests/storage/old_store.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::sqlite_backup_test {
namespace {

using absl::StatusCode;
using Store = storage::SqliteMotionStore;

// A file with a right checksum, whatever is in it.
std::string Sealed(std::string bytes) {
  bytes += storage::kBackupMark;
  storage::Sha256 digest;
  digest.Update(bytes);
  return bytes + digest.Finish();
}

void Fill(storage::MotionStore& store) {
  REQUIRE_OK(store.CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store.AddClip(SampleClip("d", "a", 1)));
  REQUIRE_OK(store.AddClip(SampleClip("d", "b", 2)));
  REQUIRE_OK(store.PutModel("d", SampleModel({SampleClip("d", "a", 1), SampleClip("d", "b", 2)})));
  REQUIRE_OK(store.PutOperation(SampleOperation("d", "op")));
  REQUIRE_OK(store.access().AddToken({.id = "robot", .salt = "s", .secret_hash = "old"}));
  REQUIRE_OK(store.access().AddAuditRecord({.request_id = "from the backup"}));
}

// Files in the store's folder besides its own.
std::string Strangers(const StoreFile& file) {
  std::string names;
  for (const auto& entry : std::filesystem::directory_iterator(file.folder())) {
    const std::string name = entry.path().filename().string();
    if (name == "store.db" || name == "store.db-wal" || name == "store.db-shm") continue;
    if (name != "store.db-lock") names += name + " ";
  }
  return names;
}

std::string SomeBackup() {
  const StoreFile file;
  const auto store = file.Open();
  Fill(*store);
  return Backup(*store);
}

}  // namespace

TEST_CASE("Backup: what is restored is what was there", "[storage][backup]") {
  const StoreFile from;
  const auto source = from.Open();
  Fill(*source);
  const std::string bytes = Backup(*source);
  REQUIRE(Strangers(from).empty());
  const StoreFile to;
  auto target = to.Open();
  REQUIRE_OK(Restore(*target, bytes, GENERATE(1'000'000, 37)));
  REQUIRE(Strangers(to).empty());
  REQUIRE(Dump(*target) == Dump(*source));
  REQUIRE(Findings(*target).empty());
  // It is a store as any other, and stays one.
  REQUIRE_OK(target->AddClip(SampleClip("d", "c", 3)));
  target.reset();
  target = to.Open();
  REQUIRE(Require(target->ListClips("d", {})).size() == 3);
}

TEST_CASE("Backup: is a store's file by itself", "[storage][backup]") {
  const StoreFile from;
  const auto source = from.Open();
  Fill(*source);
  const StoreFile to;
  std::ofstream(to.path(), std::ios::binary) << Backup(*source);
  const auto store = to.Open();
  REQUIRE(Dump(*store) == Dump(*source));
  REQUIRE_OK(store->AddClip(SampleClip("d", "c", 3)));
  REQUIRE(Findings(*store).empty());
}

TEST_CASE("Backup: is of one moment, while clips come and go", "[storage][backup]") {
  const StoreFile from;
  const auto source = from.Open();
  Fill(*source);
  std::atomic<bool> stop = false;
  std::atomic<int> errors = 0;
  // Clips come in pairs, one after the other, and each second pair goes: whoever sees the second
  // clip of a pair sees the first.
  storage::NewClip clip = SampleClip("d", "first", 20);  // here: Catch knows one thread alone
  const auto add = [&](const std::string& id) {
    clip.record.id = id;
    ++clip.record.content_hash;
    if (!source->AddClip(clip).ok()) ++errors;
  };
  std::jthread writer([&] {
    for (unsigned i = 10; !stop; ++i) {
      const std::string id = std::to_string(i);
      add(id + "-x");
      add(id + "-y");
      if (i % 2 == 0 && !source->DeleteClip("d", id + "-y").ok()) ++errors;
      if (i % 2 == 0 && !source->DeleteClip("d", id + "-x").ok()) ++errors;
    }
  });
  for (int round = 0; round < 6; ++round) {
    const std::string bytes = Backup(*source);
    const StoreFile to;
    const auto target = to.Open();
    REQUIRE_OK(Restore(*target, bytes));
    REQUIRE(Findings(*target).empty());
    for (const auto& found : Require(target->ListClips("d", {.limit = 100'000}))) {
      if (!found.id.ends_with("-y")) continue;
      REQUIRE_OK(target->GetClip("d", found.id.substr(0, found.id.size() - 1) + "x"));
    }
  }
  stop = true;
  writer.join();
  REQUIRE(errors == 0);
}

TEST_CASE("Restore: only into a store without databases", "[storage][backup]") {
  const StoreFile from;
  const auto source = from.Open();
  Fill(*source);
  const std::string bytes = Backup(*source);
  const StoreFile to;
  const auto target = to.Open();
  const auto begun = Require(target->upkeep().BeginRestore());
  REQUIRE_OK(begun->Append(bytes));
  REQUIRE_OK(begun->Check({}));
  REQUIRE_OK(target->CreateDatabase(SampleDatabase("other")));
  REQUIRE_ERROR(target->upkeep().BeginRestore(), StatusCode::kFailedPrecondition, "databases (1)");
  // Also where the database came meanwhile.
  REQUIRE_ERROR(begun->Finish({}), StatusCode::kFailedPrecondition, "databases (1)");
  REQUIRE(Require(target->ListDatabases({})).size() == 1);
}

TEST_CASE("Restore: tokens and the record of changes are those of both", "[storage][backup]") {
  const StoreFile from;
  const auto source = from.Open();
  Fill(*source);
  const StoreFile to;
  const auto target = to.Open();
  REQUIRE_OK(target->access().AddToken({.id = "admin", .salt = "s", .secret_hash = "h"}));
  REQUIRE_OK(target->access().AddToken({.id = "robot", .salt = "s", .secret_hash = "new"}));
  REQUIRE_OK(target->access().AddAuditRecord({.request_id = "of the target"}));
  REQUIRE_OK(Restore(*target, Backup(*source)));
  REQUIRE_OK(target->access().GetToken("admin"));
  REQUIRE(Require(target->access().GetToken("robot")).secret_hash == "new");
  const auto records = Require(target->access().ListAuditRecords(0, 10));
  REQUIRE(records.size() == 2);
  REQUIRE(records[0].request_id == "of the target");
  REQUIRE(records[1].request_id == "from the backup");
}

TEST_CASE("Restore: a damaged backup is refused and changes nothing", "[storage][backup]") {
  const std::string bytes = SomeBackup();
  const StoreFile to;
  const auto target = to.Open();
  REQUIRE_OK(target->access().AddToken({.id = "admin", .salt = "s", .secret_hash = "h"}));
  const std::string before = Dump(*target);
  const auto refused = [&](const std::string& damaged, const std::string& text) {
    REQUIRE_ERROR(Restore(*target, damaged), StatusCode::kInvalidArgument, text);
    REQUIRE(Dump(*target) == before);
    REQUIRE(Strangers(to).empty());
  };
  SECTION("a bit anywhere") {
    std::mt19937 random(7);
    for (int i = 0; i < 200; ++i) {
      // Evenly over the file, the first and the last bytes among them.
      const std::size_t place = i == 0    ? 0
                                : i < 100 ? bytes.size() - static_cast<std::size_t>(i)
                                          : random() % bytes.size();
      std::string damaged = bytes;
      damaged[place] = static_cast<char>(damaged[place] ^ (1 << random() % 8));
      INFO("byte " << place);
      refused(damaged, "");
    }
  }
  SECTION("cut off anywhere") {
    std::mt19937 random(8);
    for (int i = 0; i < 100; ++i) {
      const std::size_t size =
          i < 50 ? bytes.size() - 1 - static_cast<std::size_t>(i) : random() % bytes.size();
      INFO("size " << size);
      refused(bytes.substr(0, size), "");
    }
    refused(bytes.substr(0, bytes.size() / 2), "cut off");
    refused(bytes.substr(0, 99), "cut off");
    refused(bytes.substr(0, 15), "not a backup");
    refused("", "the backup is empty");
  }
  SECTION("a store's file") {
    const StoreFile store;
    { Fill(*store.Open()); }
    refused(ReadFile(store.path()), "or is the file of a store, which `motiondbd --store` serves");
  }
  SECTION("something added") { refused(bytes + "x", "cut off"); }
  SECTION("another file") {
    refused(std::string(100'000, 'x'), "not a backup");
    refused(Sealed(std::string(100'000, 'x')), "not a backup");
  }
  SECTION("another SQLite file, sealed or not") {
    const StoreFile other;
    other.Sql("CREATE TABLE photos (name); PRAGMA application_id = 7;");
    refused(Sealed(ReadFile(other.path())), "not a backup");
    refused(ReadFile(other.path()), "not a backup");
  }
  SECTION("a store that was damaged when it was copied") {
    const StoreFile worn;
    { Fill(*worn.Open()); }
    worn.Sql(ChangeByte("clip_chunk", 100, ChunksOf("b", 3)));
    refused(Backup(*worn.Open()), "the backup: databases/d/clips/b: states: chunk 0 is damaged");
    refused(Backup(*worn.Open()), "`motiondbd --store FILE` serves the backup without it");
  }
  SECTION("one whose tables are damaged") {
    const StoreFile worn;
    { Fill(*worn.Open()); }
    RuinPage(worn.path(), std::stol(worn.Sql(RootPageOf("clip"))));
    refused(Sealed(ReadFile(worn.path())), "the backup: ");
  }
  SECTION("one whose tables are others") {
    const auto changed = [&](const std::string& script, const std::string& text) {
      const StoreFile worn;
      { Fill(*worn.Open()); }
      worn.Sql(script);
      refused(Sealed(ReadFile(worn.path())), "the backup: the file: " + text);
    };
    changed("DROP TABLE token", "the table 'token' is missing");
    changed("ALTER TABLE token ADD COLUMN hint TEXT", "the table 'token' is not a store's");
    changed("CREATE TRIGGER lose AFTER INSERT ON clip BEGIN DELETE FROM clip; END",
            "a store has no trigger 'lose'");
  }
  REQUIRE_OK(Restore(*target, bytes));
}

TEST_CASE("Restore: can be cancelled, and then changes nothing", "[storage][backup]") {
  const std::string bytes = SomeBackup();
  const StoreFile to;
  const auto target = to.Open();
  REQUIRE_OK(target->access().AddToken({.id = "admin", .salt = "s", .secret_hash = "h"}));
  const std::string before = Dump(*target);
  {
    const auto restore = Require(target->upkeep().BeginRestore());
    REQUIRE_OK(restore->Append(bytes));
    REQUIRE_ERROR(restore->Finish({}), StatusCode::kFailedPrecondition, "not checked");
    REQUIRE_ERROR(restore->Check([] { return true; }), StatusCode::kCancelled, "stopped");
  }
  // While it waits to write, and while it does.
  for (const auto& [when, why] : {std::pair{1, "no longer wanted"}, {2, "stopped"}}) {
    const auto restore = Require(target->upkeep().BeginRestore());
    REQUIRE_OK(restore->Append(bytes));
    REQUIRE_OK(restore->Check({}));
    const core::Cancelled cancelled = [left = when]() mutable { return --left <= 0; };
    REQUIRE_ERROR(restore->Finish(cancelled), StatusCode::kCancelled, why);
  }
  REQUIRE(Dump(*target) == before);
  REQUIRE(Findings(*target).empty());
  REQUIRE(Strangers(to).empty());
  REQUIRE_OK(Restore(*target, bytes));
}

TEST_CASE("Restore: versions", "[storage][backup]") {
  const StoreFile to;
  const auto target = to.Open();
  SECTION("an older one is brought up to date") {
    REQUIRE_OK(Restore(*target, Sealed(OldStore(1))));
    REQUIRE(Require(target->ListClips("walks", {})).size() == 2);
    REQUIRE_OK(target->ReadModel("walks", core::Serially));
  }
  SECTION("a newer one is refused") {
    const StoreFile newer;
    { Fill(*newer.Open()); }
    newer.Sql("PRAGMA user_version = 1000");
    REQUIRE_ERROR(Restore(*target, Sealed(ReadFile(newer.path()))), StatusCode::kFailedPrecondition,
                  "the backup: the store is of version 1000, from a newer motiondb");
    REQUIRE(Require(target->ListDatabases({})).empty());
  }
}

TEST_CASE("Backup: what a killed process left is removed", "[storage][backup]") {
  const StoreFile file;
  { file.Open(); }
  for (const char* const name :
       {".store.db.backup-3", ".store.db.restore-1", ".store.db.restore-1-wal"}) {
    std::ofstream(file.folder() / name) << "left";
  }
  // Whatever somebody calls a copy of their own.
  const std::string kept = GENERATE("store.db-backup-1", "store.db-backup-2026-11-22");
  std::ofstream(file.folder() / kept) << "not ours";
  const auto store = file.Open();
  REQUIRE_OK(store->upkeep().BeginBackup({}));
  REQUIRE(Strangers(file) == kept + " ");
}

TEST_CASE("Backup: what another store's process has on its way stays", "[storage][backup]") {
  const StoreFile file;
  // The folder of `store.db` may have a store `store.db.old`, and one called as a backup is.
  const std::string kept = GENERATE(".store.db.old.restore-1", ".store.db.old.backup-1-wal",
                                    ".store.db.restore-1.restore-1", ".store.db.restore-",
                                    ".store.db.restore-1-other", ".store.db.restore-x");
  std::ofstream(file.folder() / kept) << "not ours";
  file.Open();
  REQUIRE(Strangers(file) == kept + " ");
}

TEST_CASE("Restore: a file that is gone or is another is said", "[storage][backup]") {
  const std::string bytes = SomeBackup();
  const StoreFile file;
  const auto target = file.Open();
  const auto restore = Require(target->upkeep().BeginRestore());
  REQUIRE_OK(restore->Append(bytes));
  const std::string name = Strangers(file);
  const auto path = file.folder() / name.substr(0, name.size() - 1);
  std::string expected = "gone";
  SECTION("gone") { std::filesystem::remove(path); }
  SECTION("another") {
    const auto aside = file.folder() / "aside";
    std::filesystem::copy(path, aside);
    std::filesystem::rename(aside, path);
    expected = "not the file";
  }
  SECTION("cut short") {
    std::filesystem::resize_file(path, 0);
    expected = "was changed";
  }
  REQUIRE_ERROR(restore->Check({}), StatusCode::kUnavailable, expected);
  REQUIRE_ERROR(restore->Finish({}), StatusCode::kFailedPrecondition, "not checked");
  REQUIRE(Require(target->ListDatabases({})).empty());
}

TEST_CASE("Backup: can be cancelled", "[storage][backup]") {
  const StoreFile file;
  const auto store = file.Open();
  Fill(*store);
  REQUIRE_ERROR(store->upkeep().BeginBackup([] { return true; }), StatusCode::kCancelled,
                "stopped");
  REQUIRE(Strangers(file).empty());
  const auto memory = Require(Store::Open(":memory:"));
  REQUIRE_ERROR(memory->upkeep().BeginBackup({}), StatusCode::kFailedPrecondition, "memory");
  REQUIRE_ERROR(memory->upkeep().BeginRestore(), StatusCode::kFailedPrecondition, "memory");
}

}  // namespace motiondb::tests::sqlite_backup_test
