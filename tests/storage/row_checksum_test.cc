// Each column of each row has a checksum: verify detects a change that the store did not make.
#include "storage/sqlite/row_checksum.h"

#include <catch2/catch.hpp>
#include <string>

#include "storage/sqlite/sqlite_connection.h"
#include "storage/sqlite/store_file.h"
#include "tests/storage/faults/corrupt_store.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::row_checksum_test {
namespace {

using Catch::Contains;

// Adds a row to every table with checksums.
void Fill(const StoreFile& file) {
  const auto store = file.Open();
  const storage::AuditRecord entry{.time_us = 1, .principal = "p", .method = "m"};
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d"), {.audit = &entry}));
  REQUIRE_OK(store->AddClip(SampleClip("d", "walk", 1)));
  storage::SegmentCreation hop;
  hop.segment.clip = "walk";
  hop.segment.id = "hop";
  hop.segment.end_seconds = 1;
  REQUIRE_OK(store->annotations().Edit("d", std::vector<storage::Change>{hop}, "p"));
  REQUIRE_OK(store->PutModel("d", SampleModel({SampleClip("d", "walk", 1)})));
  REQUIRE_OK(store->AcquireBuildLease("d", "server", std::chrono::seconds(1)));
  REQUIRE_OK(store->PutOperation(SampleOperation("d", "op")));
  REQUIRE_OK(store->access().AddToken({.id = "t", .salt = "s", .secret_hash = "h"}));
}

std::string FindingsAfter(const std::string& change) {
  const StoreFile file;
  Fill(file);
  file.Sql(change);
  return Findings(*file.Open());
}

}  // namespace

TEST_CASE("Verify: a changed report, which only the row checksum can detect", "[storage][verify]") {
  REQUIRE(FindingsAfter("UPDATE clip SET source_report = 'unit 1 m'") ==
          "databases/d/clips/walk: row 1 of table clip: its checksum does not match\n");
}

TEST_CASE("Verify: a changed byte of a clip's row in the file itself", "[storage][verify]") {
  const StoreFile file;
  Fill(file);
  const std::string name = file.Sql("SELECT file_name FROM clip");
  REQUIRE(name.size() > 3);
  ReplaceBytes(file.path(), name, "x" + name.substr(1));
  const auto store = file.Open();
  REQUIRE(Require(store->GetClip("d", "walk")).file_name == "x" + name.substr(1));
  REQUIRE_THAT(Findings(*store), Contains("databases/d/clips/walk: row 1 of table clip"));
}

TEST_CASE("Verify: names the row of every table that was changed", "[storage][verify]") {
  const auto [change, found] = GENERATE(table<std::string, std::string>({
      {"UPDATE database SET marker_set = 'x'", "databases/d: row 1 of table database"},
      {"UPDATE database SET last_model_version = 7", "databases/d: row 1 of table database"},
      {"UPDATE skeleton SET encoded_crc = encoded_crc + 1",
       "databases/d/skeletons/human: row 1 of table skeleton"},
      {"UPDATE model SET build_seconds = 9", "databases/d/models/1: row 1 of table model"},
      {"UPDATE model_layer SET node_count = 99", ": row 1 of table model_layer"},
      {"UPDATE model_clip SET row_crc = NULL", ": row 1 of table model_clip"},
      {"UPDATE clip SET title = 'x'", "databases/d/clips/walk: row 1 of table clip"},
      {"UPDATE segment SET label = 'x'",
       "databases/d/clips/walk/segments/hop: row 1 of table segment"},
      {"UPDATE tombstone SET clip = 'x'", ": row 1 of table tombstone"},
      {"UPDATE edit SET author = 'x'", "databases/d/edits/2: row 1 of table edit"},
      {"UPDATE operation SET stage = 'x'", "operations/op: row 1 of table operation"},
      {"UPDATE build_lease SET fence = 7", ": row 1 of table build_lease"},
      {"UPDATE token SET role = 'admin'", "tokens/t: row 1 of table token"},
      {"UPDATE token SET expire_time_us = 0 + (expire_time_us = 0)",
       "tokens/t: row 1 of table token"},
      {"UPDATE audit SET principal = 'q'", ": row 1 of table audit"},
  }));
  REQUIRE_THAT(FindingsAfter(change), Contains(found + ": its checksum does not match\n"));
}

TEST_CASE("Row checksums: cover all columns of every table except chunk tables",
          "[storage][verify]") {
  const StoreFile file;
  Fill(file);
  const auto store = file.Open();
  const auto connection = Require(storage::OpenReader(file.path(), ""));
  for (const std::string_view table : storage::CheckedTables()) {
    INFO(table);
    REQUIRE(Require(connection->QueryInteger("SELECT count(*) FROM " + std::string(table))) > 0);
    REQUIRE(Require(storage::FindChangedRows(*connection, table)).empty());
  }
  REQUIRE(static_cast<std::size_t>(Require(connection->QueryInteger(
              "SELECT count(*) FROM pragma_table_list WHERE schema = 'main' AND type = "
              "'table' AND name NOT LIKE 'sqlite_%' AND name NOT LIKE '%_chunk'"))) ==
          storage::CheckedTables().size());
  // In each table, a change of any single column is detected.
  for (const std::string_view table : storage::CheckedTables()) {
    auto column = connection->Query("SELECT name, type FROM pragma_table_info(?)", table);
    while (Require(column.Step())) {
      const std::string name = column.Text(0);
      if (name == "row_crc") continue;
      INFO(table << "." << name);
      const auto copy = Require(storage::SqliteConnection::Open(
          ":memory:", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, ""));
      // A copy without constraints, so that any column can have any value.
      REQUIRE_OK(copy->Execute("ATTACH '" + file.path() + "' AS store; CREATE TABLE " +
                               std::string(table) + " AS SELECT * FROM store." +
                               std::string(table) +
                               "; CREATE TABLE IF NOT EXISTS database AS "
                               "SELECT * FROM store.database; CREATE TABLE IF NOT EXISTS clip AS "
                               "SELECT * FROM store.clip; DETACH store"));
      REQUIRE(Require(storage::FindChangedRows(*copy, table)).empty());
      REQUIRE_OK(copy->Execute("UPDATE " + std::string(table) + " SET " + name + " = " +
                               (column.Text(1) == "TEXT" ? "'other'" : "12345")));
      REQUIRE_FALSE(Require(storage::FindChangedRows(*copy, table)).empty());
    }
  }
}

TEST_CASE("Row checksums: are valid after every kind of change", "[storage][verify]") {
  const StoreFile file;
  Fill(file);
  const auto store = file.Open();
  REQUIRE_OK(store->AddClip(SampleClip("d", "run", 2)));
  const auto fence = Require(store->AcquireBuildLease("d", "server", std::chrono::milliseconds(1)));
  REQUIRE_OK(store->RenewBuildLease("d", fence, std::chrono::seconds(2)));
  REQUIRE_OK(store->PutModel(
      "d", SampleModel({SampleClip("d", "walk", 1), SampleClip("d", "run", 2)}), {1, fence}));
  REQUIRE_OK(store->DeleteClip("d", "run"));
  auto operation = SampleOperation("d", "op");
  operation.state = storage::OperationState::kFailed;
  REQUIRE_OK(store->PutOperation(operation));
  REQUIRE_OK(store->access().RevokeToken("t", 5));
  REQUIRE_OK(store->access().RevokeToken("t", 6));
  REQUIRE(Findings(*store).empty());
  REQUIRE_OK(store->DropModel("d", {2, fence}));
  REQUIRE_OK(store->ReleaseBuildLease("d", fence));
  REQUIRE_OK(store->PurgeDeletedClips("d"));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("e")));
  REQUIRE_OK(store->DeleteDatabase("e"));
  REQUIRE(Findings(*store).empty());
  REQUIRE_OK(store->PurgeDeletedDatabases({}));
  REQUIRE(Findings(*store).empty());
}

}  // namespace motiondb::tests::row_checksum_test
