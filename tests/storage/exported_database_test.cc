// An exported database is a backup with one database; an import is complete or shows nothing.
#include <atomic>
#include <catch2/catch.hpp>
#include <fstream>
#include <functional>
#include <random>
#include <set>
#include <string>
#include <thread>

#include "tests/storage/backup_bytes.h"
#include "tests/storage/conformance/exported_database_conformance.h"
#include "tests/storage/faults/corrupt_store.h"
#include "tests/storage/old_store.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::exported_database_test {
namespace {

using absl::StatusCode;
using storage::SqliteMotionStore;

// The tables of a database. Its operations are not exported.
constexpr const char* kExportedTables[] = {
    "database",    "skeleton",   "skeleton_chunk", "clip",      "clip_chunk", "segment",  "model",
    "model_layer", "model_clip", "model_chunk",    "tombstone", "edit",       "clip_text"};
const std::set<std::string> kOtherTables = {"build_lease", "operation", "token", "audit"};

// Returns all rows of the exported tables, without keys and the checksums that depend on them, in
// an order that does not depend on keys.
std::string Rows(const StoreFile& file) {
  std::string text;
  for (const std::string table : kExportedTables) {
    const std::string columns =
        file.Sql("SELECT group_concat('quote(' || name || ')', '||') FROM pragma_table_info('" +
                 table + "') WHERE name NOT GLOB '*_key' AND name <> 'row_crc'");
    text += table + ":\n" +
            file.Sql("SELECT group_concat(r, char(10)) FROM (SELECT " + columns + " AS r FROM " +
                     table + " ORDER BY r)") +
            "\n";
  }
  return text;
}

std::string CountRows(const StoreFile& file) {
  std::string text;
  for (const std::string table : kExportedTables) {
    text += file.Sql("SELECT count(*) FROM " + table) + " ";
  }
  return text;
}

// All stores with equal content have the same times.
storage::SqliteOptions AtNoon() {
  storage::SqliteOptions options;
  options.now_us = [] { return std::int64_t{1'700'000'000'000'000}; };
  return options;
}

std::string SomeExport() {
  const StoreFile file;
  const auto store = file.Open(AtNoon());
  FillWithEverything(*store, "other");
  FillWithEverything(*store, "d");
  return Export(*store, "d");
}

}  // namespace

TEST_CASE("Export: every table is exported or deliberately left out", "[storage][export]") {
  const StoreFile file;
  { file.Open(); }
  std::set<std::string> tables(std::begin(kExportedTables), std::end(kExportedTables));
  tables.insert(kOtherTables.begin(), kOtherTables.end());
  REQUIRE(file.Sql("SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name NOT GLOB "
                   "'sqlite_*' AND name NOT GLOB 'clip_text_*'") == std::to_string(tables.size()));
}

TEST_CASE("Import: has every row of the exported database and no other", "[storage][export]") {
  const StoreFile alone;
  { FillWithEverything(*alone.Open(AtNoon()), "d"); }
  const std::string bytes = SomeExport();
  const StoreFile to;
  auto target = to.Open();
  SECTION("into an empty store") { REQUIRE_OK(Import(*target, bytes, "d")); }
  SECTION("in the place of a database that is deleted later") {
    FillWithEverything(*target, "first");
    REQUIRE_OK(Import(*target, bytes, "d"));
    REQUIRE_OK(target->DeleteDatabase("first"));
    REQUIRE_OK(target->PurgeDeletedDatabases({}));
  }
  SECTION("restored as a backup") { REQUIRE_OK(Restore(*target, bytes)); }
  SECTION("opened as a store") {
    target.reset();
    std::ofstream(to.path(), std::ios::binary) << bytes;
    target = to.Open();
  }
  SECTION("exported again") {
    const StoreFile between;
    const auto store = between.Open();
    REQUIRE_OK(Import(*store, bytes, "d"));
    REQUIRE_OK(Import(*target, Export(*store, "d"), "d"));
  }
  SECTION("with an index of words that is corrupt where it was exported") {
    const StoreFile source;
    { FillWithEverything(*source.Open(AtNoon()), "d"); }
    CorruptPage(source.path(), std::stol(source.Sql(RootPageOf("clip_text_data"))));
    REQUIRE_OK(Import(*target, Export(*source.Open(), "d"), "d"));
  }
  REQUIRE(to.OtherFiles().empty());
  REQUIRE(Findings(*target).empty());
  REQUIRE(Require(target->ListOperations("", "", 10)).empty());
  target.reset();
  REQUIRE(Rows(to) == Rows(alone));
}

TEST_CASE("Export: is consistent while clips are added", "[storage][export]") {
  const StoreFile from;
  const auto source = from.Open();
  FillWithEverything(*source, "d");
  std::atomic<bool> stop = false;
  std::atomic<int> errors = 0;
  storage::NewClip clip = SampleClip("d", "first", 20);  // on this thread, because of Catch
  std::jthread writer([&] {
    for (int i = 0; !stop; ++i) {
      for (const char* const half : {"-x", "-y"}) {  // -y only after -x
        clip.record.id = std::to_string(i) + half;
        ++clip.record.content_hash;
        if (!source->AddClip(clip).ok()) ++errors;
      }
    }
  });
  const StoreFile to;
  const auto target = to.Open();
  for (int round = 0; round < 4; ++round) {
    const std::string name = "d" + std::to_string(round);
    REQUIRE_OK(Import(*target, Export(*source, "d"), name));
    for (const auto& found : Require(target->ListClips(name, {.limit = 100'000}))) {
      if (!found.id.ends_with("-y")) continue;
      REQUIRE_OK(target->GetClip(name, found.id.substr(0, found.id.size() - 1) + "x"));
    }
    // Also into the store that is written to meanwhile.
    REQUIRE_OK(Import(*source, Export(*source, "d"), name));
  }
  stop = true;
  writer.join();
  REQUIRE(errors == 0);
  REQUIRE(Findings(*target).empty());
  REQUIRE(Findings(*source).empty());
}

TEST_CASE("Import: a wrong file is refused and changes nothing", "[storage][export]") {
  const StoreFile to;
  const auto target = to.Open();
  FillWithEverything(*target, "kept");
  const std::string before = Dump(*target);
  const std::string rows = CountRows(to);
  const auto refused = [&](const std::string& bytes, const std::string& text,
                           StatusCode code = StatusCode::kInvalidArgument) {
    REQUIRE_ERROR(Import(*target, bytes, "new"), code, text);
    REQUIRE(Dump(*target) == before);
    REQUIRE(CountRows(to) == rows);
    REQUIRE(to.OtherFiles().empty());
  };
  const std::string bytes = SomeExport();
  SECTION("a flipped bit anywhere, or cut off anywhere") {
    std::mt19937 random(7);
    for (int i = 0; i < 60; ++i) {
      const std::size_t place =
          i < 20 ? bytes.size() - 1 - static_cast<std::size_t>(i) : random() % bytes.size();
      std::string corrupt = bytes;
      corrupt[place] = static_cast<char>(corrupt[place] ^ (1 << random() % 8));
      INFO("byte " << place);
      refused(corrupt, "");
      refused(bytes.substr(0, place), "");
    }
    refused(bytes.substr(0, bytes.size() / 2), "the exported database is cut off");
    refused("", "the exported database is empty");
    refused(bytes + "x", "cut off");
  }
  SECTION("another file") {
    refused(std::string(100'000, 'x'), "`motiondb export-database`");
    refused(Sealed(std::string(100'000, 'x')), "not a backup");
  }
  SECTION("the file of a store") {
    const StoreFile store;
    { FillWithEverything(*store.Open(), "d"); }
    refused(ReadFile(store.path()), "or is the file of a store");
  }
  SECTION("a backup with no database, or with two") {
    const StoreFile store;
    const auto source = store.Open();
    refused(Backup(*source), "the file has 0 databases; expected one");
    FillWithEverything(*source, "d");
    REQUIRE_OK(source->CreateDatabase(SampleDatabase("e")));
    refused(Backup(*source), "`motiondb restore` restores");
    REQUIRE_OK(source->DeleteDatabase("e"));
    REQUIRE_OK(Import(*target, Backup(*source), "new"));
  }
  SECTION("a database with a corrupt clip") {
    const StoreFile source;
    { FillWithEverything(*source.Open(), "d"); }
    source.Sql(ChangeByte("clip_chunk", 100, ChunksOf("run", 3)));
    refused(
        Export(*source.Open(), "d"),
        "databases/d/clips/run: states: chunk 0 is corrupt: its checksum does not match; it was "
        "corrupt when the exported database was made");
  }
  SECTION("a database with a changed row") {
    const StoreFile source;
    { FillWithEverything(*source.Open(), "d"); }
    source.Sql("UPDATE clip SET source_report = 'changed' WHERE id = 'run'");
    refused(Export(*source.Open(), "d"), "its checksum does not match");
  }
  SECTION("a newer version") {
    const StoreFile newer;
    { FillWithEverything(*newer.Open(), "d"); }
    newer.Sql("PRAGMA user_version = 1000");
    refused(Sealed(ReadFile(newer.path())), "from a newer motiondb",
            StatusCode::kFailedPrecondition);
  }
}

TEST_CASE("Import: a file of a former version is upgraded", "[storage][export]") {
  const int version = GENERATE(1, 5, 9);
  const StoreFile to;
  const auto target = to.Open();
  FillWithEverything(*target, "d");
  REQUIRE_OK(Import(*target, Sealed(OldStore(version)), "walks"));
  const StoreFile old;
  std::ofstream(old.path(), std::ios::binary) << OldStore(version);
  REQUIRE(DumpDatabase(*target, "walks") == DumpDatabase(*old.Open(), "walks"));
  REQUIRE(Findings(*target).empty());
}

TEST_CASE("Import: what an import left is purged, and other content stays", "[storage][export]") {
  std::string bytes;
  {
    const StoreFile file;
    const auto store = file.Open();
    FillWithEverything(*store, "d");
    for (unsigned i = 0; i < 90; ++i) {  // so that it takes several transactions
      REQUIRE_OK(store->AddClip(SampleClip("d", "more" + std::to_string(i), 100 + i)));
    }
    bytes = Export(*store, "d");
  }
  const StoreFile to;
  auto target = to.Open();
  FillWithEverything(*target, "kept");
  const std::string before = Dump(*target);
  const std::string rows = CountRows(to);
  {
    const auto import = Require(target->maintenance().BeginImport());
    REQUIRE_OK(import->Append(bytes));
    REQUIRE_OK(import->Check({}));
    SECTION("cancelled") {
      REQUIRE_ERROR(import->Stage([&] { return CountRows(to) != rows; }), StatusCode::kCancelled,
                    "cancelled");
      REQUIRE(CountRows(to) != rows);
    }
    SECTION("not published") {
      REQUIRE_OK(import->Stage({}));
      REQUIRE(CountRows(to) != rows);
    }
  }
  REQUIRE(Dump(*target) == before);
  REQUIRE(Findings(*target).empty());
  if (GENERATE(true, false)) {
    target.reset();
    target = to.Open();
  }
  REQUIRE_OK(target->PurgeDeletedDatabases({}));
  REQUIRE(CountRows(to) == rows);
  REQUIRE(to.OtherFiles().empty());
  REQUIRE_OK(Import(*target, bytes, "d"));
}

TEST_CASE("Import: a restore does not replace a store with a staged database",
          "[storage][export]") {
  const std::string bytes = SomeExport();
  const StoreFile to;
  const auto target = to.Open();
  auto import = Require(target->maintenance().BeginImport());
  REQUIRE_OK(import->Append(bytes));
  REQUIRE_OK(import->Check({}));
  REQUIRE_OK(import->Stage({}));
  REQUIRE_ERROR(Restore(*target, bytes), StatusCode::kFailedPrecondition, "is being imported");
  import.reset();
  REQUIRE_OK(Restore(*target, bytes));
  REQUIRE(Findings(*target).empty());
}

TEST_CASE("Export: can be cancelled", "[storage][export]") {
  const StoreFile file;
  const auto store = file.Open();
  FillWithEverything(*store, "d");
  REQUIRE_ERROR(store->maintenance().BeginExport("d", [] { return true; }), StatusCode::kCancelled,
                "cancelled while the database was copied");
  REQUIRE(file.OtherFiles().empty());
  const auto memory = Require(SqliteMotionStore::Open(":memory:"));
  REQUIRE_ERROR(memory->maintenance().BeginExport("d", {}), StatusCode::kFailedPrecondition,
                "memory");
  REQUIRE_ERROR(memory->maintenance().BeginImport(), StatusCode::kFailedPrecondition, "memory");
}

}  // namespace motiondb::tests::exported_database_test
