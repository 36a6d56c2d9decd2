// Checks that no statement of the store scans a growing table, except the listed statements.
#include <sqlite3.h>

#include <array>
#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <string>

#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/storage/conformance/motion_store_conformance.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::query_plan_test {
namespace {

// Records the statements of all connections of this process during its lifetime.
class StatementLog {
 public:
  StatementLog() {
    Seen().clear();
    sqlite3_auto_extension(reinterpret_cast<void (*)()>(&Watch));
  }
  StatementLog(const StatementLog&) = delete;
  StatementLog& operator=(const StatementLog&) = delete;
  ~StatementLog() { sqlite3_cancel_auto_extension(reinterpret_cast<void (*)()>(&Watch)); }

  static std::set<std::string>& Seen() {
    static std::set<std::string> seen;
    return seen;
  }

 private:
  static int Watch(sqlite3* database, const char**, const sqlite3_api_routines*) {
    return sqlite3_trace_v2(database, SQLITE_TRACE_STMT, &Note, nullptr);
  }
  static int Note(unsigned, void*, void* statement, void*) {
    Seen().insert(sqlite3_sql(static_cast<sqlite3_stmt*>(statement)));
    return 0;
  }
};

// Beginnings of statements that may scan, with the reason.
constexpr std::array kAllowed = {
    // The migrations to versions 8 and 10 run once.
    "UPDATE clip SET\n  given_metres_per_unit",
    "UPDATE database SET revision = 1 + ",
    "UPDATE model SET revision = (SELECT database.revision",
    // The settings of the search index.
    "SELECT k, v FROM 'main'.'clip_text_config'",
    // Runs once, at the start.
    "SELECT count(*) FROM database WHERE deleted = 0",
    // Counts the bytes of clips of older versions, at the first opening.
    "SELECT clip_key FROM clip WHERE byte_count IS NULL",
    // `verify` reads all rows.
    "SELECT rowid, title, description, tags, labels, subject, file_name FROM clip_text",
    "SELECT model_key, name, version",
    "SELECT skeleton_key, skeleton.id",
    // Fills the index of an exported database or of a corrupt one.
    "SELECT clip.clip_key, title, description, subject, file_name, annotations, label FROM clip ",
    "SELECT type, name, tbl_name, ifnull(sql, '') FROM sqlite_schema ",
    // ListDatabaseStates lists all databases. The index of unfinished operations has only those.
    "SELECT name, database_key, revision, row_crc FROM database ",
    "SELECT id, name, state, progress, stage, model_version, error_code, error_message, "
    "operation.create_time_us, update_time_us, kind, database_key FROM operation JOIN database "
    "USING "
    "(database_key) WHERE deleted = 0 AND state IN ",
};

bool IsAllowed(const std::string& sql) {
  for (const char* const beginning : kAllowed) {
    if (sql.starts_with(beginning)) return true;
  }
  return sql.find("motiondb_crc(") != std::string::npos && sql.starts_with("SELECT");  // verify
}

// Returns the steps of a query plan that scan a table or make a temporary index.
std::string ScansOf(sqlite3* database, const std::string& sql) {
  sqlite3_stmt* plan = nullptr;
  const std::string explain = "EXPLAIN QUERY PLAN " + sql;
  if (sqlite3_prepare_v2(database, explain.c_str(), -1, &plan, nullptr) != SQLITE_OK) return "";
  std::string scans;
  while (sqlite3_step(plan) == SQLITE_ROW) {
    const std::string step = reinterpret_cast<const char*>(sqlite3_column_text(plan, 3));
    // The index of a virtual table: a search for words (M) or a row id (=).
    const bool uses_index = step.find("VIRTUAL TABLE INDEX 0:M") != step.npos ||
                            step.find("VIRTUAL TABLE INDEX 0:=") != step.npos;
    const bool is_scan =
        step.starts_with("SCAN ") && step.find("CONSTANT ROW") == step.npos && !uses_index;
    if (is_scan || step.find("AUTOMATIC") != step.npos) scans += step + "; ";
  }
  sqlite3_finalize(plan);
  return scans;
}

class OnFile final : public StoreUnderTest {
 public:
  storage::MotionStore& Get() override { return *store_; }

 private:
  StoreFile file_;
  std::unique_ptr<storage::SqliteMotionStore> store_ =
      file_.Open({.now_us = [] { return kPutTime; }});
};

void CheckPlans(const std::set<std::string>& statements) {
  const StoreFile file;
  file.Open();
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open(file.path().c_str(), &database) == SQLITE_OK);
  for (const std::string& sql : statements) {
    if (IsAllowed(sql)) continue;
    INFO(sql);
    CHECK(ScansOf(database, sql) == "");
  }
  sqlite3_close(database);
}

}  // namespace

TEST_CASE("SqliteMotionStore: no statement scans a growing table", "[storage][plan]") {
  const StatementLog log;
  TestMotionStore([] { return std::make_unique<OnFile>(); });
  CheckPlans(StatementLog::Seen());
}

TEST_CASE("SqliteMotionStore: the plan test records statements and detects scans",
          "[storage][plan]") {
  const StatementLog log;
  const StoreFile file;
  {
    const auto store = file.Open();
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("a")));
  }
  CHECK(StatementLog::Seen().size() > 5);
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open(file.path().c_str(), &database) == SQLITE_OK);
  CHECK(ScansOf(database, "SELECT title FROM clip WHERE title = 'walk'") == "SCAN clip; ");
  CHECK(ScansOf(database, "SELECT title FROM clip WHERE clip_key = 1") == "");
  CHECK(
      ScansOf(database,
              "SELECT id FROM operation WHERE state IN ('pending', 'running') ORDER BY sequence") ==
      "SCAN operation USING INDEX unfinished_operation; ");
  sqlite3_close(database);
}

}  // namespace motiondb::tests::query_plan_test
