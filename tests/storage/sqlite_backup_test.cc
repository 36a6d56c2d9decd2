// A backup is a consistent snapshot of a running store; a restore is complete or changes nothing.
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
#include "tests/storage/faults/corrupt_store.h"
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

void Fill(storage::MotionStore& store) {
  REQUIRE_OK(store.CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store.AddClip(SampleClip("d", "a", 1)));
  REQUIRE_OK(store.AddClip(SampleClip("d", "b", 2)));
  REQUIRE_OK(store.PutModel("d", SampleModel({SampleClip("d", "a", 1), SampleClip("d", "b", 2)})));
  REQUIRE_OK(store.PutOperation(SampleOperation("d", "op")));
  REQUIRE_OK(store.access().AddToken({.id = "robot", .salt = "s", .secret_hash = "old"}));
  REQUIRE_OK(store.access().AddAuditRecord({.request_id = "from the backup"}));
}

std::string SomeBackup() {
  const StoreFile file;
  const auto store = file.Open();
  Fill(*store);
  return Backup(*store);
}

}  // namespace

TEST_CASE("Backup: a restore returns the same content", "[storage][backup]") {
  const StoreFile from;
  const auto source = from.Open();
  Fill(*source);
  const std::string bytes = Backup(*source);
  REQUIRE(from.OtherFiles().empty());
  const StoreFile to;
  auto target = to.Open();
  REQUIRE_OK(Restore(*target, bytes, GENERATE(1'000'000, 37)));
  REQUIRE(to.OtherFiles().empty());
  REQUIRE(Dump(*target) == Dump(*source));
  REQUIRE(Findings(*target).empty());
  // The target is a normal store, also after reopening.
  REQUIRE_OK(target->AddClip(SampleClip("d", "c", 3)));
  target.reset();
  target = to.Open();
  REQUIRE(Require(target->ListClips("d", {})).size() == 3);
}

TEST_CASE("Backup: can be opened as a store", "[storage][backup]") {
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

TEST_CASE("Backup: is consistent while clips are added and deleted", "[storage][backup]") {
  const StoreFile from;
  const auto source = from.Open();
  Fill(*source);
  std::atomic<bool> stop = false;
  std::atomic<int> errors = 0;
  // Clips are added in pairs, first -x, then -y; every second pair is deleted, first -y, then -x. A
  // snapshot that contains -y must contain -x.
  storage::NewClip clip = SampleClip("d", "first", 20);  // on this thread, because of Catch
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
  for (int round = 0; round < 6; ++round) RequireWholePairs(Backup(*source));
  stop = true;
  writer.join();
  REQUIRE(errors == 0);
}

TEST_CASE("Restore: requires a store without databases", "[storage][backup]") {
  const StoreFile from;
  const auto source = from.Open();
  Fill(*source);
  const std::string bytes = Backup(*source);
  const StoreFile to;
  const auto target = to.Open();
  const auto begun = Require(target->maintenance().BeginRestore());
  REQUIRE_OK(begun->Append(bytes));
  REQUIRE_OK(begun->Check({}));
  REQUIRE_OK(target->CreateDatabase(SampleDatabase("other")));
  REQUIRE_ERROR(target->maintenance().BeginRestore(), StatusCode::kFailedPrecondition,
                "databases (1)");
  // Also if the database was created meanwhile.
  REQUIRE_ERROR(begun->Finish({}), StatusCode::kFailedPrecondition, "databases (1)");
  REQUIRE(Require(target->ListDatabases({})).size() == 1);
}

TEST_CASE("Restore: merges tokens and audit logs", "[storage][backup]") {
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

TEST_CASE("Restore: a corrupt backup is refused and changes nothing", "[storage][backup]") {
  const std::string bytes = SomeBackup();
  const StoreFile to;
  const auto target = to.Open();
  REQUIRE_OK(target->access().AddToken({.id = "admin", .salt = "s", .secret_hash = "h"}));
  const std::string before = Dump(*target);
  const auto refused = [&](const std::string& corrupt, const std::string& text) {
    REQUIRE_ERROR(Restore(*target, corrupt), StatusCode::kInvalidArgument, text);
    REQUIRE(Dump(*target) == before);
    REQUIRE(to.OtherFiles().empty());
  };
  SECTION("a flipped bit anywhere") {
    std::mt19937 random(7);
    for (int i = 0; i < 200; ++i) {
      // The first byte, the last 99 bytes, and random bytes.
      const std::size_t place = i == 0    ? 0
                                : i < 100 ? bytes.size() - static_cast<std::size_t>(i)
                                          : random() % bytes.size();
      std::string corrupt = bytes;
      corrupt[place] = static_cast<char>(corrupt[place] ^ (1 << random() % 8));
      INFO("byte " << place);
      refused(corrupt, "");
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
  SECTION("an extra byte") { refused(bytes + "x", "cut off"); }
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
  SECTION("a store that was corrupt when it was copied") {
    const StoreFile source;
    { Fill(*source.Open()); }
    source.Sql(ChangeByte("clip_chunk", 100, ChunksOf("b", 3)));
    refused(Backup(*source.Open()), "the backup: databases/d/clips/b: states: chunk 0 is corrupt");
    refused(Backup(*source.Open()), "`motiondbd --store FILE` serves the backup without it");
  }
  SECTION("a store with corrupt tables") {
    const StoreFile source;
    { Fill(*source.Open()); }
    CorruptPage(source.path(), std::stol(source.Sql(RootPageOf("clip"))));
    refused(Sealed(ReadFile(source.path())), "the backup: ");
  }
  SECTION("a store with different tables") {
    const auto changed = [&](const std::string& script, const std::string& text) {
      const StoreFile source;
      { Fill(*source.Open()); }
      source.Sql(script);
      refused(Sealed(ReadFile(source.path())), "the backup: the file: " + text);
    };
    changed("DROP TABLE token", "the table 'token' is missing");
    changed("ALTER TABLE token ADD COLUMN hint TEXT", "the table 'token' was changed");
    changed("CREATE TRIGGER lose AFTER INSERT ON clip BEGIN DELETE FROM clip; END",
            "unexpected trigger 'lose'");
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
    const auto restore = Require(target->maintenance().BeginRestore());
    REQUIRE_OK(restore->Append(bytes));
    REQUIRE_ERROR(restore->Finish({}), StatusCode::kFailedPrecondition, "not checked");
    REQUIRE_ERROR(restore->Check([] { return true; }), StatusCode::kCancelled, "cancelled");
  }
  // While it waits to write, and during the write.
  for (const auto& [when, why] :
       {std::pair{1, "cancelled while it waited"}, {2, "cancelled while the store was copied"}}) {
    const auto restore = Require(target->maintenance().BeginRestore());
    REQUIRE_OK(restore->Append(bytes));
    REQUIRE_OK(restore->Check({}));
    const core::Cancelled cancelled = [left = when]() mutable { return --left <= 0; };
    REQUIRE_ERROR(restore->Finish(cancelled), StatusCode::kCancelled, why);
  }
  REQUIRE(Dump(*target) == before);
  REQUIRE(Findings(*target).empty());
  REQUIRE(to.OtherFiles().empty());
  REQUIRE_OK(Restore(*target, bytes));
}

TEST_CASE("Restore: versions", "[storage][backup]") {
  const StoreFile to;
  const auto target = to.Open();
  SECTION("an older version is upgraded") {
    REQUIRE_OK(Restore(*target, Sealed(OldStore(1))));
    REQUIRE(Require(target->ListClips("walks", {})).size() == 2);
    REQUIRE_OK(target->ReadModel("walks", core::RunSerially));
  }
  SECTION("a newer version is refused") {
    const StoreFile newer;
    { Fill(*newer.Open()); }
    newer.Sql("PRAGMA user_version = 1000");
    REQUIRE_ERROR(Restore(*target, Sealed(ReadFile(newer.path()))), StatusCode::kFailedPrecondition,
                  "the backup: the store is of version 1000, from a newer motiondb");
    REQUIRE(Require(target->ListDatabases({})).empty());
  }
}

TEST_CASE("Backup: temporary files of a killed process are deleted", "[storage][backup]") {
  const StoreFile file;
  { file.Open(); }
  for (const char* const name :
       {".store.db.backup-3", ".store.db.restore-1", ".store.db.restore-1-wal",
        ".store.db.export-2-wal", ".store.db.import-12"}) {
    std::ofstream(file.folder() / name) << "left";
  }
  // Names that a user may choose for a copy.
  const std::string kept = GENERATE("store.db-backup-1", "store.db-backup-2026-11-22");
  std::ofstream(file.folder() / kept) << "not ours";
  const auto store = file.Open();
  REQUIRE_OK(store->maintenance().BeginBackup({}));
  REQUIRE(file.OtherFiles() == kept + " ");
}

TEST_CASE("Backup: temporary files of another store stay", "[storage][backup]") {
  const StoreFile file;
  // The folder may contain a store `store.db.old`, or a store whose name looks like a backup's.
  const std::string kept = GENERATE(".store.db.old.restore-1", ".store.db.old.backup-1-wal",
                                    ".store.db.restore-1.restore-1", ".store.db.restore-",
                                    ".store.db.restore-1-other", ".store.db.restore-x");
  std::ofstream(file.folder() / kept) << "not ours";
  file.Open();
  REQUIRE(file.OtherFiles() == kept + " ");
}

TEST_CASE("Restore: reports that its temporary file is missing or was replaced",
          "[storage][backup]") {
  const std::string bytes = SomeBackup();
  const StoreFile file;
  const auto target = file.Open();
  const auto restore = Require(target->maintenance().BeginRestore());
  REQUIRE_OK(restore->Append(bytes));
  const std::string name = file.OtherFiles();
  const auto path = file.folder() / name.substr(0, name.size() - 1);
  std::string expected = "gone";
  SECTION("gone") { std::filesystem::remove(path); }
  SECTION("another") {
    const auto aside = file.folder() / "aside";
    std::filesystem::copy(path, aside);
    std::filesystem::rename(aside, path);
    expected = "was replaced";
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
  REQUIRE_ERROR(store->maintenance().BeginBackup([] { return true; }), StatusCode::kCancelled,
                "cancelled while the store was copied");
  REQUIRE(file.OtherFiles().empty());
  const auto memory = Require(Store::Open(":memory:"));
  REQUIRE_ERROR(memory->maintenance().BeginBackup({}), StatusCode::kFailedPrecondition, "memory");
  REQUIRE_ERROR(memory->maintenance().BeginRestore(), StatusCode::kFailedPrecondition, "memory");
}

}  // namespace motiondb::tests::sqlite_backup_test
