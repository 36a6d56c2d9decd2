// Free disk space below the reserve: additions are refused, other changes succeed.
#include <catch2/catch.hpp>
#include <cstdint>
#include <string>

#include "storage/blob/model_codec.h"
#include "storage/sql/tables/added_bytes.h"
#include "storage/sqlite/store_disk.h"
#include "tests/storage/backup_bytes.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::disk_reserve_test {
namespace {

using absl::StatusCode;

constexpr char kRefusal[] = "for deletions (--disk-reserve-mib)";

storage::SqliteOptions MoreThanThereIs() { return {.reserve_bytes = std::int64_t{1} << 60}; }

}  // namespace

TEST_CASE("SqliteMotionStore: below the reserve, additions fail and other changes succeed",
          "[storage][reserve]") {
  const StoreFile file;
  const auto walk = SampleClip("d", "walk", 1);
  {
    const auto store = file.Open();
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
    REQUIRE_OK(store->AddClip(walk));
  }
  const auto store = file.Open(MoreThanThereIs());
  REQUIRE_ERROR(store->CreateDatabase(SampleDatabase("e")), StatusCode::kResourceExhausted,
                "on the disk of '" + file.path() + "'");
  REQUIRE_ERROR(store->AddClip(SampleClip("d", "run", 2)), StatusCode::kResourceExhausted,
                kRefusal);
  REQUIRE_ERROR(store->PutModel("d", SampleModel({walk})), StatusCode::kResourceExhausted,
                kRefusal);
  REQUIRE_ERROR(store->PutExtension("d", SampleModel({walk}), 0), StatusCode::kResourceExhausted,
                kRefusal);
  REQUIRE(Require(store->ListClips("d", {})).size() == 1);

  REQUIRE_OK(store->PutOperation(SampleOperation("d", "op")));
  REQUIRE_OK(store->access().AddToken({.id = "t", .salt = "s", .secret_hash = "h"}));
  REQUIRE_OK(store->access().RevokeToken("t", 1));
  REQUIRE_OK(store->access().AddAuditRecord({.request_id = "r"}));
  REQUIRE_OK(store->DeleteClip("d", "walk"));
  REQUIRE_OK(store->DropModel("d"));
  REQUIRE_OK(store->PurgeDeletedClips("d"));
  REQUIRE_OK(store->DeleteDatabase("d"));
  REQUIRE_OK(store->PurgeDeletedDatabases({}));
}

TEST_CASE("Restore: keeps the reserve free", "[storage][reserve]") {
  const StoreFile from;
  const auto source = from.Open();
  REQUIRE_OK(source->CreateDatabase(SampleDatabase("d")));
  const StoreFile to;
  const auto target = to.Open(MoreThanThereIs());
  REQUIRE_ERROR(Restore(*target, Backup(*source)), StatusCode::kResourceExhausted, kRefusal);
  REQUIRE(Require(target->ListDatabases({})).empty());
  // Already while the backup is received.
  const auto restore = Require(target->maintenance().BeginRestore());
  REQUIRE_ERROR(restore->Append(Backup(*source)), StatusCode::kResourceExhausted, kRefusal);
}

TEST_CASE("Import: keeps the reserve free", "[storage][reserve]") {
  const StoreFile from;
  const auto source = from.Open();
  REQUIRE_OK(source->CreateDatabase(SampleDatabase("d")));
  const StoreFile to;
  const auto target = to.Open(MoreThanThereIs());
  REQUIRE_ERROR(Import(*target, Export(*source, "d"), "d"), StatusCode::kResourceExhausted,
                kRefusal);
  REQUIRE(Require(target->ListDatabases({})).empty());
}

TEST_CASE("Backup: the copy keeps the reserve free", "[storage][reserve]") {
  const StoreFile file;
  REQUIRE_OK(file.Open()->CreateDatabase(SampleDatabase("d")));
  const auto store = file.Open(MoreThanThereIs());
  REQUIRE_ERROR(store->maintenance().BeginBackup({}), StatusCode::kResourceExhausted, kRefusal);
  REQUIRE_ERROR(store->maintenance().BeginExport("d", {}), StatusCode::kResourceExhausted,
                kRefusal);
}

TEST_CASE("SqliteMotionStore: a store in memory ignores the reserve", "[storage][reserve]") {
  const auto store = Require(storage::SqliteMotionStore::Open(":memory:", MoreThanThereIs()));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store->AddClip(SampleClip("d", "walk", 1)));
}

TEST_CASE("AddedBytes: size of a clip and of a model", "[storage][reserve]") {
  auto clip = SampleClip("d", "walk", 1);
  const std::int64_t before = storage::AddedBytes(clip);
  CHECK(before >= clip.states.states.size() * 4 + clip.states.root_path.size() * 8);
  clip.file_bytes += "abc";
  CHECK(storage::AddedBytes(clip) == before + 3);
  const auto model = SampleModel({clip});
  storage::StringSink sink;
  REQUIRE_OK(storage::EncodeModel(model.parts(), sink));
  CHECK(storage::AddedBytes(model) == std::ssize(sink.bytes()));
}

}  // namespace motiondb::tests::disk_reserve_test
