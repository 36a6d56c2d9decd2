// A deleted database is invisible immediately; its content is freed in pieces, between other
// writes.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/model/model_builder.h"
#include "tests/storage/backup_bytes.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::deleted_databases_test {
namespace {

using absl::StatusCode;

constexpr char kRows[] =
    "SELECT (SELECT count(*) FROM clip) + (SELECT count(*) FROM clip_chunk) + (SELECT count(*) "
    "FROM skeleton) + (SELECT count(*) FROM skeleton_chunk) + (SELECT count(*) FROM model) + "
    "(SELECT count(*) FROM model_layer) + (SELECT count(*) FROM model_clip) + (SELECT count(*) "
    "FROM model_chunk) + (SELECT count(*) FROM operation) + (SELECT count(*) FROM database) + "
    "(SELECT count(*) FROM segment) + (SELECT count(*) FROM tombstone) + (SELECT count(*) FROM "
    "edit) + (SELECT count(*) FROM clip_text)";
constexpr char kChunkBytes[] = "SELECT ifnull(sum(length(chunk)), 0) FROM clip_chunk";

// Creates a database with every kind of content: models, an extension, a deleted clip, an
// operation.
void Fill(storage::MotionStore& store, const std::string& database, const std::string& operation) {
  const auto sample = [&](const std::string& id, unsigned seed) {
    return SampleClip(database, id, seed);
  };
  REQUIRE_OK(store.CreateDatabase(SampleDatabase(database)));
  for (const auto& clip : {sample("walk", 1), sample("run", 2), sample("gone", 3)}) {
    REQUIRE_OK(store.AddClip(clip));
  }
  const core::Model model = SampleModel({sample("walk", 1), sample("gone", 3)});
  REQUIRE_OK(store.PutModel(database, SampleModel({sample("walk", 1)})));
  REQUIRE_OK(store.PutModel(database, model));
  const auto run = sample("run", 2);
  std::vector<core::BuildInput> inputs;
  inputs.push_back({run.record.id, run.record.label, run.states, run.record.subject});
  REQUIRE_OK(store.PutExtension(
      database, Require(core::ExtendModel(model, std::move(inputs), core::RunSerially)), 0.1));
  REQUIRE_OK(store.DeleteClip(database, "gone"));
  storage::ClipChange title;
  title.clip = "walk";
  title.title = "Title";
  REQUIRE_OK(store.annotations().Edit(database, std::vector<storage::Change>{title}, "me"));
  REQUIRE_OK(store.PutOperation(SampleOperation(database, operation)));
}

}  // namespace

TEST_CASE("Deleted databases: are removed completely; other databases stay",
          "[storage][deletion]") {
  const StoreFile file;
  const auto store = file.Open();
  Fill(*store, "kept", "kept-op");
  const std::string before = file.Sql(kRows);
  const std::string dump = Dump(*store);
  Fill(*store, "d", "d-op");
  REQUIRE(file.Sql(kRows) != before);
  REQUIRE_OK(store->DeleteDatabase("d"));
  REQUIRE(file.Sql(kRows) != before);
  REQUIRE(Dump(*store) == dump);
  REQUIRE(Findings(*store).empty());
  REQUIRE_ERROR(store->GetOperation("d-op"), StatusCode::kNotFound, "d-op");
  REQUIRE_ERROR(store->ListOperations("", "d-op", 10), StatusCode::kNotFound, "d-op");
  REQUIRE_ERROR(store->DeleteDatabase("d"), StatusCode::kNotFound, "'d'");
  const std::string hidden = file.Sql("SELECT name FROM database WHERE deleted = 1");
  REQUIRE_ERROR(store->GetDatabase(hidden), StatusCode::kNotFound, hidden);
  REQUIRE_ERROR(store->DeleteDatabase(hidden), StatusCode::kNotFound, hidden);

  REQUIRE_OK(store->PurgeDeletedDatabases({}));
  REQUIRE(file.Sql(kRows) == before);
  REQUIRE(Dump(*store) == dump);
  REQUIRE(Findings(*store).empty());
}

TEST_CASE("Deleted databases: the name can be reused immediately, repeatedly",
          "[storage][deletion]") {
  const StoreFile file;
  const auto store = file.Open();
  for (int round = 0; round < 3; ++round) {
    const std::string operation = fmt::format("op-{}", round);
    Fill(*store, "d", operation);
    REQUIRE_OK(store->DeleteDatabase("d"));
  }
  REQUIRE(file.Sql("SELECT count(*) FROM database") == "3");
  // The operations of the former databases do not become those of the new one.
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  REQUIRE_ERROR(store->PutOperation(SampleOperation("d", "op-0")), StatusCode::kNotFound, "op-0");
  REQUIRE(Require(store->ListOperations("d", "", 10)).empty());
  REQUIRE_OK(store->DeleteDatabase("d"));
  REQUIRE_OK(store->PurgeDeletedDatabases({}));
  REQUIRE(file.Sql(kRows) == "0");
}

TEST_CASE("Deleted databases: are freed a few megabytes at a time, between other writes",
          "[storage][deletion]") {
  const StoreFile file;
  auto store = file.Open();
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  for (unsigned seed = 1; seed < 4; ++seed) {
    auto large = SampleClip("d", "large", seed);
    large.file_bytes.assign(9'000'000, static_cast<char>(seed));
    REQUIRE_OK(store->AddClip(large));
  }
  REQUIRE_OK(store->DeleteDatabase("d"));
  const auto stored_bytes = [&] { return std::stol(file.Sql(kChunkBytes)); };
  const long whole = stored_bytes();
  REQUIRE(whole > 27'000'000);

  long before = whole;
  long max_freed = 0;
  int turns = 0;
  const auto write_between = [&] {
    max_freed = std::max(max_freed, before - stored_bytes());
    before = stored_bytes();
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("new" + std::to_string(++turns))));
    return false;
  };
  SECTION("to the end") { REQUIRE_OK(store->PurgeDeletedDatabases(write_between)); }
  SECTION("cancelled, then continued after the store was reopened") {
    const auto stop = [&] { return write_between() || before < whole / 2; };
    REQUIRE_ERROR(store->PurgeDeletedDatabases(stop), StatusCode::kCancelled, "");
    REQUIRE(stored_bytes() > 0);
    store.reset();
    store = file.Open();
    REQUIRE_OK(store->PurgeDeletedDatabases(write_between));
  }
  REQUIRE(stored_bytes() == 0);
  REQUIRE(turns > 6);
  REQUIRE(max_freed > 0);
  REQUIRE(max_freed < 5 << 20);
  REQUIRE(file.Sql("SELECT count(*) FROM database WHERE deleted = 1") == "0");
}

TEST_CASE("Deleted databases: do not prevent a restore and are not corruption in a backup",
          "[storage][deletion]") {
  const StoreFile from;
  const auto source = from.Open();
  Fill(*source, "d", "d-op");
  REQUIRE_OK(source->DeleteDatabase("d"));
  Fill(*source, "kept", "kept-op");
  const StoreFile to;
  const auto target = to.Open();
  Fill(*target, "d", "d-op");
  REQUIRE_OK(target->DeleteDatabase("d"));
  REQUIRE_OK(Restore(*target, Backup(*source)));
  REQUIRE_OK(target->PurgeDeletedDatabases({}));
  REQUIRE(Dump(*target) == Dump(*source));
  REQUIRE(to.Sql("SELECT count(*) FROM database") == "1");
}

}  // namespace motiondb::tests::deleted_databases_test
