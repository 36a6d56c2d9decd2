#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "absl/cleanup/cleanup.h"
#include "storage/sql/connection/connection.h"
#include "storage/sqlite/schema.h"
#include "storage/sqlite/sqlite_connection.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "storage/sqlite/store_file.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_file.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::sqlite_open_test {
namespace {

using absl::StatusCode;

std::string Version() { return std::to_string(storage::Migrations().size()); }

// Requires that opening fails with `text`, that the file does not change and no file is created.
void RequireLeftAlone(const StoreFile& file, const std::string& text) {
  const auto entries = [&] {
    return std::distance(std::filesystem::directory_iterator(file.folder()), {});
  };
  const std::string before = ReadFile(file.path());
  const auto entries_before = entries();
  REQUIRE_ERROR(file.TryOpen(), StatusCode::kFailedPrecondition, text);
  REQUIRE(ReadFile(file.path()) == before);
  REQUIRE(entries() == entries_before);
}

}  // namespace

TEST_CASE("SqliteMotionStore: a new file is a store of the current version", "[storage][open]") {
  const StoreFile file;
  file.Open();
  REQUIRE(file.Sql("PRAGMA application_id") == std::to_string(storage::kApplicationId));
  REQUIRE(file.Sql("PRAGMA user_version") == Version());
  REQUIRE(file.Sql("PRAGMA journal_mode") == "wal");
  REQUIRE(file.Sql("PRAGMA page_size") == "16384");
  REQUIRE(file.Sql("PRAGMA integrity_check") == "ok");
  REQUIRE(file.Sql("SELECT count(*) FROM pragma_table_list WHERE schema = 'main' AND strict = 0 "
                   "AND type = 'table' "
                   "AND name NOT LIKE 'sqlite_%'") == "0");
  file.Open();
  REQUIRE(file.Sql("PRAGMA user_version") == Version());
}

TEST_CASE("SqliteMotionStore: an empty file becomes a store", "[storage][open]") {
  const StoreFile file;
  std::ofstream(file.path()).flush();
  REQUIRE_OK(file.Open()->CreateDatabase(SampleDatabase("d")));
  REQUIRE(file.Sql("SELECT name FROM database") == "d");
}

TEST_CASE("SqliteMotionStore: a path with special characters of URIs is a path",
          "[storage][open]") {
  const StoreFile file;
  const std::string path = (file.folder() / "50%25?mode=ro#1 .db").string();
  for (int i = 0; i < 2; ++i) {
    REQUIRE_OK(storage::SqliteMotionStore::Open(path));
    REQUIRE(std::filesystem::file_size(path) > 0);
  }
}

TEST_CASE("SqliteMotionStore: a relative path that looks like a URI is a path", "[storage][open]") {
  const StoreFile file;
  const absl::Cleanup back = [former = std::filesystem::current_path()] {
    std::filesystem::current_path(former);
  };
  std::filesystem::current_path(file.folder());
  const auto other = Require(storage::SqliteMotionStore::Open("x.db"));
  REQUIRE_OK(other->CreateDatabase(SampleDatabase("d")));
  for (int i = 0; i < 2; ++i) {  // created, then opened again
    const auto store = Require(storage::SqliteMotionStore::Open("file:x.db"));
    REQUIRE(Require(store->ListDatabases({})).empty());
    REQUIRE(std::filesystem::file_size(file.folder() / "file:x.db") > 0);
    REQUIRE(std::filesystem::exists(file.folder() / "file:x.db-lock"));
    REQUIRE_OK(store->maintenance().BeginBackup({}));
  }
  REQUIRE(Require(storage::ReadStoreVersion("file:x.db")) == std::stoi(Version()));
}

TEST_CASE("SqliteMotionStore: a file that is not a store is refused and not changed",
          "[storage][open]") {
  const StoreFile file;
  SECTION("a text file") {
    std::ofstream(file.path()) << "Dear diary, " << std::string(9000, '.');
    RequireLeftAlone(file, "a file of another kind");
  }
  SECTION("a few bytes") {
    std::ofstream(file.path()) << "x";
    RequireLeftAlone(file, "a file of another kind");
  }
  SECTION("another program's SQLite file") {
    file.Sql("CREATE TABLE photos (name); PRAGMA application_id = 7;");
    RequireLeftAlone(file, "another SQLite file");
  }
  SECTION("another program's SQLite file with a log") {
    file.Sql("PRAGMA journal_mode = WAL; CREATE TABLE photos (name);");
    RequireLeftAlone(file, "another SQLite file");
  }
  SECTION("a folder") {
    std::filesystem::create_directory(file.path());
    REQUIRE_ERROR(file.TryOpen(), StatusCode::kFailedPrecondition, "other than a file");
  }
}

TEST_CASE("SqliteMotionStore: a missing folder is an error", "[storage][open]") {
  const StoreFile file;
  REQUIRE_ERROR(storage::SqliteMotionStore::Open(file.path() + "/no/store.db"),
                StatusCode::kUnavailable, "no/store.db");
  REQUIRE_ERROR(storage::SqliteMotionStore::Open(""), StatusCode::kInvalidArgument, "empty");
}

TEST_CASE("SqliteMotionStore: a store of a newer version is refused", "[storage][open]") {
  const StoreFile file;
  REQUIRE_OK(file.Open()->CreateDatabase(SampleDatabase("d")));
  file.Sql("PRAGMA user_version = 1000");
  REQUIRE_ERROR(file.TryOpen(), StatusCode::kFailedPrecondition, "version 1000");
  REQUIRE(file.Sql("PRAGMA user_version") == "1000");
  REQUIRE(file.Sql("SELECT name FROM database") == "d");
}

TEST_CASE("SqliteMotionStore: the files of a killed process contain all acknowledged changes",
          "[storage][open]") {
  const StoreFile file;
  const auto store = file.Open();
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  for (unsigned i = 1; i < 4; ++i) {
    REQUIRE_OK(store->AddClip(SampleClip("d", "walk", i)));
    // Copy the file and its log while the store is open, as a kill leaves them.
    const StoreFile killed;
    std::filesystem::copy_file(file.path(), killed.path());
    std::filesystem::copy_file(file.path() + "-wal", killed.path() + "-wal");
    const auto recovered = killed.Open();
    const auto clips = Require(recovered->ListClips("d", {}));
    REQUIRE(clips.size() == i);
    REQUIRE(Same(Require(recovered->ReadClipStates("d", clips.back().id)), SampleStates(60, i)));
  }
}

TEST_CASE("SqliteMotionStore: opening a file twice is refused", "[storage][open]") {
  const StoreFile file;
  auto store = file.Open();
  REQUIRE_ERROR(file.TryOpen(), StatusCode::kFailedPrecondition, "in use (process ");
  const std::string link = (file.folder() / "link.db").string();
  std::filesystem::create_symlink(file.path(), link);
  REQUIRE_ERROR(storage::SqliteMotionStore::Open(link), StatusCode::kFailedPrecondition, "in use");
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  store.reset();
  REQUIRE_OK(file.Open()->GetDatabase("d"));
}

TEST_CASE("SqliteMotionStore: a store with two names is refused by either name",
          "[storage][open]") {
  const StoreFile file;
  REQUIRE_OK(file.Open()->CreateDatabase(SampleDatabase("d")));
  const std::string link = (file.folder() / "link.db").string();
  const auto require_refused = [](const std::string& path) {
    REQUIRE_ERROR(storage::SqliteMotionStore::Open(path), StatusCode::kFailedPrecondition,
                  "'" + path + "' has 2 names (hard links)");
  };
  {
    const auto store = file.Open();
    std::filesystem::create_hard_link(file.path(), link);
    require_refused(link);
    REQUIRE_FALSE(std::filesystem::exists(link + "-lock"));
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("e")));
  }
  require_refused(link);
  require_refused(file.path());
  std::filesystem::remove(link);
  REQUIRE_OK(file.Open()->GetDatabase("e"));
}

TEST_CASE("SqliteMotionStore: an empty file with two names is refused", "[storage][open]") {
  const StoreFile file;
  std::ofstream(file.path()).flush();
  std::filesystem::create_hard_link(file.path(), file.folder() / "link.db");
  RequireLeftAlone(file, "has 2 names");
}

TEST_CASE("Migrate: runs each missing migration once, in order", "[storage][migration]") {
  const StoreFile file;
  const auto connection = Require(
      storage::SqliteConnection::Open(file.path(), SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, ""));
  const char* const steps[] = {"CREATE TABLE t (a INTEGER) STRICT;", "INSERT INTO t VALUES (1);",
                               "UPDATE t SET a = a * 10; INSERT INTO t VALUES (2);"};
  REQUIRE_OK(storage::Migrate(*connection, std::span(steps).first(1)));
  REQUIRE_OK(storage::Migrate(*connection, steps));
  REQUIRE_OK(storage::Migrate(*connection, steps));
  REQUIRE(Require(connection->QueryInteger("SELECT sum(a) FROM t")) == 12);
  REQUIRE(Require(connection->QueryInteger("PRAGMA user_version")) == 3);
  REQUIRE_ERROR(storage::Migrate(*connection, std::span(steps).first(2)),
                StatusCode::kFailedPrecondition, "version 3");
}

TEST_CASE("Migrate: a failed migration keeps the former version", "[storage][migration]") {
  const StoreFile file;
  const auto connection = Require(
      storage::SqliteConnection::Open(file.path(), SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, ""));
  const char* const steps[] = {"CREATE TABLE t (a INTEGER) STRICT;", "INSERT INTO t VALUES (1);",
                               "INSERT INTO t VALUES (2); INSERT INTO t VALUES ('x');"};
  REQUIRE_OK(storage::Migrate(*connection, std::span(steps).first(1)));
  REQUIRE_FALSE(storage::Migrate(*connection, steps).ok());
  REQUIRE(Require(connection->QueryInteger("PRAGMA user_version")) == 1);
  REQUIRE(Require(connection->QueryInteger("SELECT count(*) FROM t")) == 0);
}

TEST_CASE("OpenReader: cannot write", "[storage][open]") {
  const StoreFile file;
  const auto store = file.Open();
  const auto reader = Require(storage::OpenReader(file.path(), ""));
  REQUIRE_FALSE(reader->Execute("DELETE FROM database").ok());
  REQUIRE_FALSE(reader->Execute("PRAGMA wal_checkpoint(TRUNCATE)").ok());
  REQUIRE_OK(reader->Execute("SELECT * FROM database"));
}

}  // namespace motiondb::tests::sqlite_open_test
