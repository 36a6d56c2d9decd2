// A migration copies a whole store between a file and PostgreSQL, and continues after any
// interruption.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "storage/migration/migrate_store.h"
#include "storage/postgres/postgres_motion_store.h"
#include "tests/storage/conformance/exported_database_conformance.h"
#include "tests/storage/postgres/postgres_cluster.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::migration_test {
namespace {

using absl::StatusCode;
using storage::MigrateStore;
using storage::PostgresMotionStore;

// Everything, also what is hidden: a deleted database and an import that has ended.
void FillStore(storage::MotionStore& store) {
  FillWithEverything(store, "d");
  FillWithEverything(store, "deleted");
  REQUIRE_OK(store.DeleteDatabase("deleted"));
  REQUIRE_OK(store.CreateDatabase(SampleDatabase("empty")));
  auto odd = SampleClip("empty", "odd", 5);
  odd.record.title = std::string("a\0b \xff \x01 \xc3\xa4", 10);
  odd.record.description = "it's 100% \\x41 \"quoted\"";
  REQUIRE_OK(store.AddClip(odd));
  storage::TokenRecord token{.id = "t", .salt = std::string("\0\xff", 2), .secret_hash = "h"};
  REQUIRE_OK(store.access().AddToken(token));
  REQUIRE_OK(store.access().AddAuditRecord({.method = "m", .request_id = "r"}));
}

// Returns all rows of all tables of a file, with keys and checksums.
std::string AllRows(const std::string& path) {
  std::string text;
  for (const char* const table :
       {"database", "skeleton", "skeleton_chunk", "clip", "clip_chunk", "segment", "model",
        "model_layer", "model_clip", "model_chunk", "tombstone", "edit", "operation", "token",
        "audit", "clip_text"}) {
    const std::string name = table;
    const std::string columns =
        RunSql(path, "SELECT group_concat('quote(' || name || ')', '||') FROM pragma_table_info('" +
                         name + "')");
    text += name + ":\n" +
            RunSql(path, "SELECT group_concat(r, char(10)) FROM (SELECT " + columns +
                             " AS r FROM " + name + " ORDER BY r)") +
            "\n";
  }
  return text;
}

absl::Status Migrate(const std::string& from, const std::string& to) {
  return MigrateStore(from, to, {}, {});
}

}  // namespace

TEST_CASE("Migration: from a file to PostgreSQL and back, every row is the same",
          "[storage][postgres][migration]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const StoreFile first;
  { FillStore(*first.Open()); }
  const std::string rows = AllRows(first.path());
  const PostgresDatabase database(*cluster);
  std::vector<storage::MigrationProgress> progress;
  REQUIRE_OK(MigrateStore(first.path(), database.Url(),
                          [&](const storage::MigrationProgress& now) { progress.push_back(now); },
                          {}));
  REQUIRE(progress.front().phase == storage::MigrationProgress::Phase::kCopy);
  REQUIRE(progress.back().phase == storage::MigrationProgress::Phase::kPublish);
  REQUIRE(progress.back().bytes > 0);
  {
    const auto store = Require(PostgresMotionStore::Open(database.Url()));
    REQUIRE(Dump(*store) == Dump(*first.Open()));
    REQUIRE(Findings(*store).empty());
  }
  const StoreFile second;
  REQUIRE_OK(Migrate(database.Url(), second.path()));
  REQUIRE(AllRows(second.path()) == rows);
  REQUIRE(second.OtherFiles().empty());
  {
    const auto store = second.Open();
    REQUIRE(Findings(*store).empty());
    REQUIRE_OK(store->AddClip(SampleClip("d", "new", 9)));
  }
  // New rows in PostgreSQL get keys above the copied ones.
  const auto store = Require(PostgresMotionStore::Open(database.Url()));
  REQUIRE_OK(store->AddClip(SampleClip("d", "new", 9)));
  REQUIRE_OK(store->PutOperation(SampleOperation("d", "new-op")));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("new")));
  REQUIRE_OK(store->PurgeDeletedDatabases({}));
  REQUIRE(Findings(*store).empty());
}

TEST_CASE("Migration: continues after an interruption at any point",
          "[storage][postgres][migration]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const StoreFile file;
  {
    const auto store = file.Open();
    FillStore(*store);
    // Several steps.
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("many")));
    for (unsigned i = 0; i < 90; ++i) {
      REQUIRE_OK(store->AddClip(SampleClip("many", "c" + std::to_string(i), 100 + i)));
    }
  }
  const std::string rows = AllRows(file.path());
  const PostgresDatabase database(*cluster);
  const StoreFile back;
  for (const auto& [from, to] :
       {std::pair(file.path(), database.Url()), std::pair(database.Url(), back.path())}) {
    // Each attempt gets one poll further than the one before, and then has done nothing more.
    int attempts = 0;
    absl::Status migrated;
    do {
      ++attempts;
      bool is_continued = false;
      migrated = MigrateStore(
          from, to, [&](const storage::MigrationProgress& now) { is_continued = now.is_continued; },
          [left = attempts]() mutable { return --left < 0; });
      REQUIRE(is_continued == (attempts > 1));
      if (migrated.ok()) break;
      REQUIRE(migrated.code() == StatusCode::kCancelled);
      if (to == database.Url()) {
        REQUIRE_ERROR(PostgresMotionStore::Open(to), StatusCode::kFailedPrecondition,
                      "migration into it was interrupted");
        REQUIRE_ERROR(Migrate(to, back.path()), StatusCode::kFailedPrecondition, "interrupted");
      } else {
        REQUIRE_FALSE(std::filesystem::exists(to));
      }
    } while (attempts < 200);
    REQUIRE_OK(migrated);
    REQUIRE(attempts > 6);
  }
  REQUIRE(AllRows(back.path()) == rows);
  REQUIRE(Findings(*back.Open()).empty());
}

TEST_CASE("Migration: continues after it was interrupted while it published the file",
          "[storage][migration]") {
  const StoreFile file;
  { FillStore(*file.Open()); }
  const StoreFile copy;
  int polls = 0;
  REQUIRE_ERROR(MigrateStore(
                    file.path(), copy.path(),
                    [&](const storage::MigrationProgress& now) {
                      if (now.phase == storage::MigrationProgress::Phase::kPublish) polls = 1;
                    },
                    [&] { return polls == 1; }),
                StatusCode::kCancelled, "continues");
  RunSql(copy.path() + "-migration", "DROP TABLE motiondb_migration");
  REQUIRE_OK(Migrate(file.path(), copy.path()));
  REQUIRE(AllRows(copy.path()) == AllRows(file.path()));
  REQUIRE(copy.OtherFiles().empty());
}

TEST_CASE("Migration: refuses what it must not mix or change", "[storage][postgres][migration]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const StoreFile file;
  auto open = file.Open();
  FillStore(*open);
  const PostgresDatabase database(*cluster);
  const PostgresDatabase filled(*cluster);
  auto other = Require(PostgresMotionStore::Open(filled.Url()));
  REQUIRE_OK(other->CreateDatabase(SampleDatabase("mine")));

  REQUIRE_ERROR(Migrate(file.path(), database.Url()), StatusCode::kFailedPrecondition, "in use");
  open.reset();
  REQUIRE_ERROR(Migrate(file.path(), filled.Url()), StatusCode::kFailedPrecondition, "in use");
  REQUIRE_ERROR(Migrate(filled.Url(), file.path()), StatusCode::kFailedPrecondition, "in use");
  other.reset();
  REQUIRE_ERROR(Migrate(file.path(), filled.Url()), StatusCode::kFailedPrecondition, "not empty");
  REQUIRE_OK(PostgresMotionStore::Open(filled.Url()));
  REQUIRE_ERROR(Migrate(filled.Url(), file.path()), StatusCode::kFailedPrecondition, "exists");
  REQUIRE_ERROR(Migrate(file.path(), file.path()), StatusCode::kFailedPrecondition, "");
  REQUIRE_ERROR(Migrate(filled.Url(), filled.Url()), StatusCode::kInvalidArgument, "both");
  REQUIRE_ERROR(Migrate(file.path() + "x", database.Url()), StatusCode::kNotFound, "no store");
  REQUIRE_ERROR(Migrate(file.path(), database.Url("&pooled=1")), StatusCode::kInvalidArgument,
                "pooler");
  REQUIRE_ERROR(Migrate(database.Url(), file.path() + "x"), StatusCode::kFailedPrecondition,
                "version 0");
  const std::string text = (file.folder() / "text").string();
  std::ofstream(text) << "not a store";
  REQUIRE_ERROR(Migrate(text, database.Url()), StatusCode::kFailedPrecondition,
                "not a motiondb store");
  // A migration from another store was interrupted.
  REQUIRE_ERROR(MigrateStore(file.path(), database.Url(), {}, [] { return true; }),
                StatusCode::kCancelled, "the same migration continues");
  const StoreFile another;
  { FillStore(*another.Open()); }
  REQUIRE_ERROR(Migrate(another.path(), database.Url()), StatusCode::kFailedPrecondition,
                "has the beginning of a migration from");
  REQUIRE_OK(Migrate(file.path(), database.Url()));
}

TEST_CASE("Migration: finds a change of the source and a corrupt copy",
          "[storage][postgres][migration]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const StoreFile file;
  { FillStore(*file.Open()); }
  const PostgresDatabase database(*cluster);
  // Interrupted before the comparison.
  const auto interrupt = [&](int polls) {
    return MigrateStore(file.path(), database.Url(), {},
                        [left = polls]() mutable { return --left < 0; });
  };
  REQUIRE(interrupt(3).code() == StatusCode::kCancelled);
  const auto migrate = [&] { return Migrate(file.path(), database.Url()); };
  SECTION("the source was changed") {
    { REQUIRE_OK(file.Open()->AddClip(SampleClip("d", "new", 9))); }
    REQUIRE_ERROR(migrate(), StatusCode::kDataLoss, "the source was changed");
  }
  SECTION("a row of the copy") {
    database.Sql("SET session_replication_role = replica; UPDATE audit SET method = 'x'");
    REQUIRE_ERROR(migrate(), StatusCode::kDataLoss, "table audit, row 1: 'method' differs");
  }
  SECTION("a checksum of the copy") {
    database.Sql("SET session_replication_role = replica; UPDATE audit SET row_crc = 5");
    REQUIRE_ERROR(migrate(), StatusCode::kDataLoss, "the checksum of the copy");
  }
  SECTION("a bit of a chunk") {
    database.Sql(
        "UPDATE clip_chunk SET chunk = set_byte(chunk, 40, 255 - get_byte(chunk, 40)) "
        "WHERE kind = 3");
    REQUIRE_ERROR(migrate(), StatusCode::kDataLoss, "'chunk' differs");
  }
  SECTION("a lost row") {
    database.Sql("DELETE FROM edit WHERE edit_key = (SELECT max(edit_key) FROM edit)");
    REQUIRE_ERROR(migrate(), StatusCode::kDataLoss, "is missing in the copy");
  }
  REQUIRE_ERROR(PostgresMotionStore::Open(database.Url()), StatusCode::kFailedPrecondition,
                "migration");
}

TEST_CASE("Migration: a corrupt row of the source is not copied as if it were right",
          "[storage][postgres][migration]") {
  PostgresCluster* const cluster = PostgresCluster::Find();
  if (cluster == nullptr) return;
  const StoreFile file;
  { FillStore(*file.Open()); }
  file.Sql("UPDATE clip SET title = 'changed' WHERE clip_key = 2");
  const PostgresDatabase database(*cluster);
  REQUIRE_ERROR(Migrate(file.path(), database.Url()), StatusCode::kDataLoss,
                "row 2 of table clip: its checksum does not match");
}

}  // namespace motiondb::tests::migration_test
