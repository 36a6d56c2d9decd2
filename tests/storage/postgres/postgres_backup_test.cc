// A backup of a PostgreSQL store is the file of an SQLite store; either kind of store restores it.
#include <stdlib.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>
#include <thread>
#include <utility>

#include "storage/postgres/postgres_motion_store.h"
#include "tests/storage/backup_bytes.h"
#include "tests/storage/conformance/exported_database_conformance.h"
#include "tests/storage/postgres/postgres_cluster.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::postgres_backup_test {
namespace {

using absl::StatusCode;
using storage::PostgresMotionStore;

std::unique_ptr<PostgresMotionStore> Open(const PostgresDatabase& database,
                                          const std::string& parameters = "") {
  return Require(PostgresMotionStore::Open(database.Url(parameters)));
}

void Fill(storage::MotionStore& store) {
  FillWithEverything(store, "other");
  FillWithEverything(store, "d");
  REQUIRE_OK(store.DeleteDatabase("other"));
  REQUIRE_OK(store.access().AddToken({.id = "robot", .salt = "s", .secret_hash = "old"}));
  REQUIRE_OK(store.access().AddAuditRecord({.request_id = "from the backup"}));
}

}  // namespace

TEST_CASE("Postgres backup: either kind of store restores it", "[storage][postgres][backup]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const std::string parameters = GENERATE("", "&pooled=1");
  const PostgresDatabase database(*cluster);
  const auto source = Open(database, parameters);
  Fill(*source);
  const std::string dump = Dump(*source);
  const std::string bytes = Backup(*source);
  const StoreFile file;
  {
    const auto target = file.Open();
    REQUIRE_OK(Restore(*target, bytes));
    REQUIRE(Dump(*target) == dump);
    REQUIRE(Findings(*target).empty());
    REQUIRE_OK(target->AddClip(SampleClip("d", "new", 9)));
    REQUIRE_OK(target->DeleteClip("d", "new"));
    REQUIRE_OK(target->PurgeDeletedDatabases({}));
  }
  // A backup of the SQLite store, with an edit, into PostgreSQL.
  const PostgresDatabase other(*cluster);
  const auto target = Open(other, parameters);
  REQUIRE_OK(Restore(*target, bytes, 37'000));
  REQUIRE(Dump(*target) == dump);
  REQUIRE(Findings(*target).empty());
  // New rows get new keys.
  REQUIRE_OK(target->AddClip(SampleClip("d", "new", 9)));
  REQUIRE_OK(target->CreateDatabase(SampleDatabase("e")));
  REQUIRE_OK(target->AddClip(SampleClip("e", "new", 9)));
  REQUIRE_OK(target->PutOperation(SampleOperation("e", "new-op")));
  REQUIRE_OK(target->access().AddToken({.id = "new", .salt = "s", .secret_hash = "h"}));
  REQUIRE(Require(target->access().ListTokens("", 10)).size() == 2);
  REQUIRE_OK(target->PurgeDeletedDatabases({}));
  REQUIRE(Findings(*target).empty());
  REQUIRE(Require(source->ListDatabases({})).size() == 1);
}

TEST_CASE("Postgres backup: a restore keeps the tokens and audit entries of the store",
          "[storage][postgres][backup]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const StoreFile file;
  const auto source = file.Open();
  Fill(*source);
  const PostgresDatabase database(*cluster);
  const auto target = Open(database);
  REQUIRE_OK(target->access().AddToken({.id = "admin", .salt = "s", .secret_hash = "h"}));
  REQUIRE_OK(target->access().AddToken({.id = "robot", .salt = "s", .secret_hash = "new"}));
  REQUIRE_OK(target->access().AddAuditRecord({.request_id = "of the target"}));
  const std::string bytes = Backup(*source);
  {
    const auto restore = Require(target->maintenance().BeginRestore());
    REQUIRE_OK(restore->Append(bytes));
    REQUIRE_OK(restore->Check({}));
    const core::Cancelled cancelled = [left = 2]() mutable { return --left <= 0; };
    REQUIRE_ERROR(restore->Finish(cancelled), StatusCode::kCancelled, "while the backup");
    REQUIRE(Require(target->ListDatabases({})).empty());
    REQUIRE(Require(target->access().ListTokens("", 10)).size() == 2);
  }
  REQUIRE_OK(Restore(*target, bytes));
  REQUIRE_OK(target->access().GetToken("admin"));
  REQUIRE(Require(target->access().GetToken("robot")).secret_hash == "new");
  const auto records = Require(target->access().ListAuditRecords(0, 100));
  REQUIRE(records[0].request_id == "of the target");
  REQUIRE(records[1].request_id == "from the backup");
  REQUIRE(Findings(*target).empty());
  REQUIRE_ERROR(Restore(*target, bytes), StatusCode::kFailedPrecondition, "databases (1)");
}

TEST_CASE("Postgres backup: a restored database is another one than that with its name before",
          "[storage][postgres][backup][servers]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const StoreFile file;
  const auto source = file.Open();
  Fill(*source);
  const PostgresDatabase database(*cluster);
  const auto target = Open(database);
  const auto other_server = Open(database);
  // With the names and keys of those in the backup.
  REQUIRE_OK(target->CreateDatabase(SampleDatabase("other")));
  REQUIRE_OK(target->CreateDatabase(SampleDatabase("d")));
  const std::int64_t former_id = Require(target->GetDatabase("d")).id;
  REQUIRE(former_id == Require(source->GetDatabase("d")).id);
  const storage::NewClip clip = SampleClip("d", "walk", 1);
  REQUIRE_OK(target->AddClip(clip));
  const auto fence =
      Require(other_server->AcquireBuildLease("d", "other server", std::chrono::hours(1)));
  REQUIRE_OK(target->DeleteDatabase("other"));
  REQUIRE_OK(target->DeleteDatabase("d"));

  REQUIRE_OK(Restore(*target, Backup(*source)));
  REQUIRE(Dump(*target) == Dump(*source));
  const std::int64_t id = Require(target->GetDatabase("d")).id;
  REQUIRE(id > former_id);
  REQUIRE(Require(other_server->ListDatabaseStates()).at(0).id == id);
  // Calls that have begun with the former database change nothing.
  REQUIRE_ERROR(other_server->RenewBuildLease("d", fence, std::chrono::hours(1)),
                StatusCode::kAborted, "lease");
  REQUIRE_ERROR(other_server->PutDerived("d", {}, fence), StatusCode::kAborted, "lease");
  REQUIRE_ERROR(other_server->DeleteClip("d", "walk", {.database_id = former_id}),
                StatusCode::kAborted, "another one has its name");
  // Names of deleted databases contain their keys.
  REQUIRE_OK(target->DeleteDatabase("d"));
  for (int i = 0; i < 3; ++i) {
    REQUIRE_OK(target->CreateDatabase(SampleDatabase("d")));
    REQUIRE_OK(target->DeleteDatabase("d"));
  }
  REQUIRE_OK(target->PurgeDeletedDatabases({}));
  REQUIRE(Findings(*target).empty());
}

TEST_CASE("Postgres backup: a server that frees a deleted database takes no restored row for one",
          "[storage][postgres][backup][servers]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  const auto target = Open(database);
  const auto other_server = Open(database);
  REQUIRE_OK(target->CreateDatabase(SampleDatabase("d")));
  storage::NewClip large = SampleClip("d", "large", 1);
  large.file_bytes = std::string(12 << 20, 'x');  // freed in several pieces
  REQUIRE_OK(target->AddClip(large));
  REQUIRE_OK(target->AddClip(SampleClip("d", "small", 2)));
  REQUIRE_OK(target->PutModel("d", SampleModel({large})));
  const std::string dump = Dump(*target);
  const std::string bytes = Backup(*target);
  // A restore before each piece.
  int pieces = 0;
  for (bool is_restored = true; std::exchange(is_restored, false); ++pieces) {
    REQUIRE_OK(target->DeleteDatabase("d"));
    const core::Cancelled before_piece = [&, piece = 0]() mutable {
      if (piece++ == pieces) {
        is_restored = true;
        REQUIRE_OK(Restore(*target, bytes));
      }
      return false;
    };
    REQUIRE_OK(other_server->PurgeDeletedDatabases(before_piece));
    if (!is_restored) REQUIRE_OK(Restore(*target, bytes));
    REQUIRE(Dump(*target) == dump);
    REQUIRE(Findings(*target).empty());
  }
  REQUIRE(pieces > 5);
}

TEST_CASE("Postgres backup: a restore is refused during an import of another server",
          "[storage][postgres][backup][servers]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  const auto target = Open(database);
  REQUIRE_OK(target->CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(target->AddClip(SampleClip("d", "walk", 1)));
  const std::string bytes = Backup(*target);
  const std::string exported = Export(*target, "d");
  REQUIRE_OK(target->DeleteDatabase("d"));
  const auto other_server = Open(database);
  const auto import = Require(other_server->maintenance().BeginImport());
  REQUIRE_OK(import->Append(exported));
  REQUIRE_OK(import->Check({}));
  REQUIRE_OK(import->Stage({}));
  REQUIRE_ERROR(Restore(*target, bytes), StatusCode::kFailedPrecondition, "is being imported");
}

TEST_CASE("Postgres backup: is consistent while clips are added and deleted",
          "[storage][postgres][backup][concurrency]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  const auto source = Open(database);
  REQUIRE_OK(source->CreateDatabase(SampleDatabase("d")));
  std::atomic<bool> stop = false;
  std::atomic<int> errors = 0;
  // Clips are added in pairs, first -x, then -y. A snapshot that contains -y must contain -x.
  storage::NewClip clip = SampleClip("d", "first", 20);  // on this thread, because of Catch
  std::jthread writer([&] {
    for (unsigned i = 10; !stop; ++i) {
      for (const char* const suffix : {"-x", "-y"}) {
        clip.record.id = std::to_string(i) + suffix;
        ++clip.record.content_hash;
        if (!source->AddClip(clip).ok()) ++errors;
      }
    }
  });
  for (int round = 0; round < 3; ++round) RequireWholePairs(Backup(*source));
  stop = true;
  writer.join();
  REQUIRE(errors == 0);
}

TEST_CASE("Postgres backup: has what is corrupt, and a restore finds it",
          "[storage][postgres][backup][verify]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  const auto source = Open(database);
  Fill(*source);
  const auto [sql, found] = GENERATE(table<std::string, std::string>({
      {"UPDATE clip SET title = 'x' WHERE id = 'walk'", "row "},
      {"UPDATE clip_chunk SET chunk = set_byte(chunk, 40, 255 - get_byte(chunk, 40)) WHERE kind = "
       "3",
       "states: chunk 0 is corrupt"},
      {"DELETE FROM clip_chunk WHERE kind = 3", "states: expected 4 more bytes"},
  }));
  database.Sql("SET session_replication_role = replica; " + sql);
  const StoreFile file;
  const auto target = file.Open();
  REQUIRE_ERROR(Restore(*target, Backup(*source)), StatusCode::kInvalidArgument, found);
  REQUIRE(Require(target->ListDatabases({})).empty());
  if (found != "row ") return;
  REQUIRE_ERROR(Restore(*target, Export(*source, "d")), StatusCode::kInvalidArgument, found);
}

TEST_CASE("Postgres import: another server does not purge it until its server has ended",
          "[storage][postgres][export]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const PostgresDatabase database(*cluster);
  // With a pooler there are no locks of sessions.
  auto importer = Open(database, GENERATE("", "&pooled=1"));
  const auto other = Open(database);
  FillWithEverything(*other, "d");
  const std::string bytes = Export(*other, "d");
  const auto stage = [&] {
    auto import = Require(importer->maintenance().BeginImport());
    REQUIRE_OK(import->Append(bytes));
    REQUIRE_OK(import->Check({}));
    REQUIRE_OK(import->Stage({}));
    return import;
  };
  auto import = stage();
  REQUIRE_OK(other->PurgeDeletedDatabases({}));
  REQUIRE_ERROR(import->Publish("d"), StatusCode::kAlreadyExists, "");
  REQUIRE_OK(other->PurgeDeletedDatabases({}));
  REQUIRE_OK(import->Publish("copy"));
  REQUIRE(DumpDatabase(*other, "copy") == DumpDatabase(*other, "d"));
  const std::string hidden = "SELECT count(*) FROM database WHERE deleted = 1";
  // Deleted by another server than the one that imported it.
  REQUIRE_OK(other->DeleteDatabase("copy"));
  REQUIRE_OK(other->PurgeDeletedDatabases({}));
  REQUIRE(database.Sql(hidden) == "0");
  // An import that was given up, on its own server.
  stage();
  REQUIRE(database.Sql(hidden) == "1");
  REQUIRE_OK(other->PurgeDeletedDatabases({}));
  REQUIRE(database.Sql(hidden) == "1");
  REQUIRE_OK(importer->PurgeDeletedDatabases({}));
  REQUIRE(database.Sql(hidden) == "0");
  // The server stands still, or ends, before it has published.
  const auto expire = [&] { database.Sql("UPDATE build_lease SET expire_time_us = 1"); };
  import = stage();
  expire();
  REQUIRE_OK(other->PurgeDeletedDatabases({}));
  REQUIRE_ERROR(import->Publish("copy"), StatusCode::kAborted, "import the file again");
  import = stage();
  import.reset();
  importer.reset();
  REQUIRE_OK(other->PurgeDeletedDatabases({}));
  REQUIRE(database.Sql(hidden) == "1");
  expire();
  REQUIRE_OK(other->PurgeDeletedDatabases({}));
  REQUIRE(database.Sql(hidden) == "0");
}

TEST_CASE("Postgres backup: can be cancelled, and leaves no files", "[storage][postgres][backup]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const StoreFile temporary;
  const char* const former = std::getenv("TMPDIR");
  setenv("TMPDIR", temporary.folder().c_str(), 1);
  const PostgresDatabase database(*cluster);
  {
    const auto source = Open(database);
    Fill(*source);
    auto& maintenance = source->maintenance();
    const core::Cancelled cancelled = [] { return true; };
    REQUIRE_ERROR(maintenance.BeginBackup(cancelled), StatusCode::kCancelled, "while the store");
    REQUIRE_ERROR(maintenance.BeginExport("d", cancelled), StatusCode::kCancelled,
                  "while the database");
    const PostgresDatabase other(*cluster);
    REQUIRE_OK(Restore(*Open(other), Backup(*source)));
    REQUIRE_THAT(temporary.OtherFiles(), Catch::StartsWith("motiondb-copies-"));
  }
  REQUIRE(temporary.OtherFiles().empty());
  if (former == nullptr) {
    unsetenv("TMPDIR");
  } else {
    setenv("TMPDIR", former, 1);
  }
}

}  // namespace motiondb::tests::postgres_backup_test
