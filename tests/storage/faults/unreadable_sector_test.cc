// An unreadable sector of the disk affects only the data on it.
#include <catch2/catch.hpp>
#include <fstream>
#include <string>

#include "tests/storage/faults/fault_disk.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::unreadable_sector_test {
namespace {

using absl::StatusCode;

// Returns a clip whose file and states use many pages.
storage::NewClip LongClip(const std::string& id, unsigned seed) {
  auto clip = SampleClip("d", id, seed);
  clip.states = SampleStates(6000, seed);
  clip.record.frame_count = 6000;
  clip.file_bytes = Encoded(SampleStates(6000, seed + 1000));
  return clip;
}

// Stores the clips "a" and "b" and a model of the clips `model`. Returns the offset of `bytes`, a
// part of a blob, in the store file.
std::int64_t FillAndFind(const StoreFile& file, const std::vector<storage::NewClip>& model,
                         const std::string& bytes) {
  {
    const auto store = file.Open();
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
    REQUIRE_OK(store->AddClip(LongClip("a", 1)));
    REQUIRE_OK(store->AddClip(SampleClip("d", "b", 2)));
    REQUIRE_OK(store->PutModel("d", SampleModel(model)));
  }
  const std::size_t place = ReadFile(file.path()).find(bytes);
  REQUIRE(place != std::string::npos);
  return static_cast<std::int64_t>(place);
}

// Returns some bytes from the middle of a blob.
std::string Within(const std::string& blob) { return blob.substr(200'000, 32); }

}  // namespace

TEST_CASE("Unreadable sector: of a clip's states", "[storage][sector]") {
  const StoreFile file;
  FaultDisk disk;
  const auto b = SampleClip("d", "b", 2);
  const auto place = FillAndFind(file, {b}, Within(Encoded(LongClip("a", 1).states)));
  disk.LoseSector(file.path(), place, GENERATE(SQLITE_IOERR_READ, SQLITE_IOERR_CORRUPTFS));
  const auto store = file.Open({.reader_count = 1, .now_us = {}, .vfs = FaultDisk::kVfs});
  REQUIRE_ERROR(store->ReadClipStates("d", "a"), StatusCode::kDataLoss, "clip 'a'");
  REQUIRE_OK(store->ReadClipStates("d", "b"));
  REQUIRE_OK(store->ReadModel("d", core::RunSerially));
  REQUIRE(Require(store->ListClips("d", {})).size() == 2);
  REQUIRE_THAT(Findings(*store), Catch::Contains("databases/d/clips/a: "));

  // The clip can be deleted and ingested again; its remaining data does not interfere.
  REQUIRE_OK(store->DeleteClip("d", "a"));
  REQUIRE_ERROR(store->PurgeDeletedClips("d"), StatusCode::kDataLoss, "");
  REQUIRE_OK(store->AddClip(LongClip("a", 1)));
  REQUIRE_OK(store->AddClip(SampleClip("d", "c", 3)));
  REQUIRE_OK(store->DeleteClip("d", "c"));
  REQUIRE_ERROR(store->PurgeDeletedClips("d"), StatusCode::kDataLoss, "");
  REQUIRE_OK(store->PutModel("d", SampleModel({LongClip("a", 1), b})));
  REQUIRE_ERROR(store->PutModel("d", SampleModel({SampleClip("d", "c", 3)})), StatusCode::kNotFound,
                "'c'");
  REQUIRE_OK(store->ReadModel("d", core::RunSerially));
}

TEST_CASE("Unreadable sector: of a clip's file", "[storage][sector]") {
  const StoreFile file;
  FaultDisk disk;
  const auto a = LongClip("a", 1);
  const auto place = FillAndFind(file, {a}, Within(a.file_bytes));
  disk.LoseSector(file.path(), place, GENERATE(SQLITE_IOERR_READ, SQLITE_IOERR_CORRUPTFS));
  const auto store = file.Open({.reader_count = 1, .now_us = {}, .vfs = FaultDisk::kVfs});
  REQUIRE_ERROR(store->ReadClipSource("d", "a"), StatusCode::kDataLoss, "clip 'a'");
  REQUIRE_OK(store->ReadClipStates("d", "a"));
  REQUIRE_OK(store->DeleteClip("d", "a"));
  REQUIRE_ERROR(store->GetClip("d", "a"), StatusCode::kNotFound, "a");
  REQUIRE_OK(store->PutModel("d", SampleModel({SampleClip("d", "b", 2)})));
}

TEST_CASE("Unreadable sector: start of the page on which a clip's file begins",
          "[storage][sector]") {
  const StoreFile file;
  constexpr std::size_t kPage = 16384;
  auto a = SampleClip("d", "a", 1);
  a.file_bytes = std::string(15'000, 'a');  // fits on one page
  {
    const auto store = file.Open();
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
    REQUIRE_OK(store->AddClip(SampleClip("d", "b", 2)));
    REQUIRE_OK(store->AddClip(a));
    REQUIRE_OK(store->AddClip(SampleClip("d", "c", 3)));
    REQUIRE_OK(store->PutModel("d", SampleModel({SampleClip("d", "b", 2)})));
  }
  const std::size_t place = ReadFile(file.path()).find(a.file_bytes);
  REQUIRE(place != std::string::npos);
  const auto zero_sector = [&] {
    std::fstream stream(file.path(), std::ios::in | std::ios::out | std::ios::binary);
    stream.seekp(static_cast<std::streamoff>(place / kPage * kPage));
    stream << std::string(512, '\0');
  };
  FaultDisk disk;
  std::string vfs;
  bool counted = true;
  SECTION("read as zeros") { zero_sector(); }
  SECTION("read as zeros, in a store of a version without byte_count") {
    file.Sql("UPDATE clip SET byte_count = NULL");
    zero_sector();
    counted = false;
  }
  SECTION("read error") {
    disk.LoseSector(file.path(), static_cast<std::int64_t>(place / kPage * kPage),
                    GENERATE(SQLITE_IOERR_READ, SQLITE_IOERR_CORRUPTFS));
    vfs = FaultDisk::kVfs;
  }
  const auto store = file.Open({.reader_count = 1, .now_us = {}, .vfs = vfs});
  REQUIRE_ERROR(store->ReadClipSource("d", "a"), StatusCode::kDataLoss, "clip 'a'");
  REQUIRE(Require(store->ListClips("d", {})).size() == 3);
  REQUIRE((Require(store->GetClip("d", "a")).byte_count > 0) == counted);
  REQUIRE(Require(store->GetClip("d", "c")).byte_count > 0);
  REQUIRE_OK(store->ReadClipStates("d", "c"));
  REQUIRE_OK(store->ReadModel("d", core::RunSerially));
  REQUIRE_THAT(Findings(*store), Catch::Contains("databases/d/clips/a: ") &&
                                     !Catch::Contains("clips/b") && !Catch::Contains("clips/c"));
  const auto verifier = Require(store->maintenance().BeginVerify({}));
  std::vector<storage::Corruption> found;
  while (Require(verifier->Step(found))) {
  }
  REQUIRE(verifier->totals().clip_count == 3);
  REQUIRE_OK(store->DeleteClip("d", "a"));
  REQUIRE_OK(store->AddClip(SampleClip("d", "a", 1)));
  REQUIRE_OK(store->PutModel("d", SampleModel({SampleClip("d", "a", 1), SampleClip("d", "c", 3)})));
}

TEST_CASE("Unreadable sector: of a model", "[storage][sector]") {
  const StoreFile file;
  FaultDisk disk;
  const auto a = LongClip("a", 1);
  const core::Model model = SampleModel({a});
  const auto place = FillAndFind(file, {a}, Within(Encoded(model.parts())));
  disk.LoseSector(file.path(), place, GENERATE(SQLITE_IOERR_READ, SQLITE_IOERR_CORRUPTFS));
  const auto store = file.Open({.reader_count = 1, .now_us = {}, .vfs = FaultDisk::kVfs});
  REQUIRE_ERROR(store->ReadModel("d", core::RunSerially), StatusCode::kDataLoss, "model 1");
  REQUIRE(Require(store->PutModel("d", model)).version == 2);
  REQUIRE_OK(store->ReadModel("d", core::RunSerially));
}

TEST_CASE("Unreadable sector: of a deleted database", "[storage][sector]") {
  const StoreFile file;
  FaultDisk disk;
  const auto a = LongClip("a", 1);
  const core::Model model = SampleModel({a});
  const std::string lost = GENERATE_COPY(Within(Encoded(a.states)), Within(a.file_bytes),
                                         Within(Encoded(model.parts())));
  disk.LoseSector(file.path(), FillAndFind(file, {a}, lost), SQLITE_IOERR_READ);
  const auto store = file.Open({.reader_count = 1, .now_us = {}, .vfs = FaultDisk::kVfs});
  REQUIRE_OK(store->DeleteDatabase("d"));
  REQUIRE(Require(store->ListDatabases({})).empty());
  // One chunk cannot be freed; it stays with its clip or model.
  for (int round = 0; round < 2; ++round) {
    REQUIRE_ERROR(store->PurgeDeletedDatabases({}), StatusCode::kDataLoss, "");
    REQUIRE(file.Sql("SELECT (SELECT count(*) FROM clip_chunk) + (SELECT count(*) FROM "
                     "model_chunk) + (SELECT count(*) FROM skeleton_chunk)") == "1");
    REQUIRE(file.Sql("SELECT (SELECT count(*) FROM clip) + (SELECT count(*) FROM model)") == "1");
  }
  // It does not interfere, and is freed when the disk can read it again.
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store->AddClip(a));
  disk.Arm(FaultDisk::Fault::kNone, 0);
  REQUIRE_OK(store->PurgeDeletedDatabases({}));
  REQUIRE(file.Sql("SELECT count(*) FROM database") == "1");
  REQUIRE(file.Sql("SELECT count(*) FROM clip") == "1");
  REQUIRE(Findings(*store).empty());
}

TEST_CASE("Unreadable sector: everything works after the sector can be read again",
          "[storage][sector]") {
  const StoreFile file;
  FaultDisk disk;
  const auto b = SampleClip("d", "b", 2);
  const auto place = FillAndFind(file, {b}, Within(Encoded(LongClip("a", 1).states)));
  disk.LoseSector(file.path(), place, GENERATE(SQLITE_IOERR_READ, SQLITE_IOERR_CORRUPTFS));
  const auto store = file.Open({.reader_count = 1, .now_us = {}, .vfs = FaultDisk::kVfs});
  REQUIRE_ERROR(store->ReadClipStates("d", "a"), StatusCode::kDataLoss, "clip 'a'");
  disk.Arm(FaultDisk::Fault::kNone, 0);
  REQUIRE_OK(store->ReadClipStates("d", "a"));
  REQUIRE(Findings(*store).empty());
}

}  // namespace motiondb::tests::unreadable_sector_test
