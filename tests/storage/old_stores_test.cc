// Stores of former versions can be opened, with all their content.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "core/model/model.h"
#include "storage/sqlite/schema.h"
#include "storage/sqlite/store_file.h"
#include "tests/storage/old_store.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::old_stores_test {

TEST_CASE("SqliteMotionStore: a store of a former version is upgraded with its content",
          "[storage][migration]") {
  const int version = GENERATE(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11);
  const StoreFile file;
  std::ofstream(file.path(), std::ios::binary) << OldStore(version);
  REQUIRE(file.Sql("PRAGMA user_version") == std::to_string(version));
  {
    const auto store = file.Open();
    REQUIRE(Findings(*store).empty());
    REQUIRE(Require(store->GetDatabase("walks")).settings.glitches == core::GlitchPolicy::kRepair);
    const auto clips = Require(store->ListClips("walks", {}));
    REQUIRE(clips.size() == 2);
    REQUIRE(clips[0].id == "squat");
    REQUIRE(clips[1].id == "walk");
    REQUIRE(clips[1].frame_count == 90);
    REQUIRE(clips[0].byte_count + clips[1].byte_count ==
            std::stoll(file.Sql("SELECT sum(length(chunk)) FROM clip_chunk")));
    const core::Model model = Require(store->ReadModel("walks", core::RunSerially));
    REQUIRE(model.clips().size() == 2);
    REQUIRE(model.frame_count() == 180);
    REQUIRE(model.layer_count() == 5);
    const auto models = Require(store->ListModels("walks", 0, 10));
    REQUIRE(models.size() == 3);
    REQUIRE(models[0].version == 3);
    REQUIRE(models[0].current);
    REQUIRE(models[0].added_clip_count == 0);
    // Its states have representation version 1 and must be derived again.
    const auto staleness = Require(store->FindModelStaleness("walks"));
    REQUIRE(staleness.missing.empty());
    REQUIRE(staleness.removed == 0);
    REQUIRE(staleness.outdated == 2);
    REQUIRE(staleness.to_derive == 2);
    for (const auto& clip : clips) {
      REQUIRE(clip.representation_version == 1);
      REQUIRE(clip.tried_version == 1);
      REQUIRE(clip.derive_error.empty());
      REQUIRE_FALSE(clip.given.metres_per_unit);
      REQUIRE_FALSE(clip.given.up_axis);
      REQUIRE(clip.given.frame_rate_hz == clip.source_frame_rate_hz);
      REQUIRE(clip.given_leg_length_m == clip.leg_length_m);
      REQUIRE(clip.given.take.empty());
      REQUIRE(clip.format == core::FileFormat::kBvh);
    }
    for (const auto& operation : Require(store->ListOperations("walks", "", 10))) {
      REQUIRE(operation.kind == storage::OperationKind::kRebuild);
    }
    REQUIRE(Require(store->ListOperations("walks", "", 10)).size() == 3);
    REQUIRE(Require(store->ReadClipSource("walks", "walk")).file_bytes.starts_with("HIERARCHY"));
    REQUIRE_OK(store->GetSkeleton("walks", clips[0].skeleton_id));
    // Labels are segments; clips, segments and the model have revisions.
    for (const auto& clip : clips) {
      REQUIRE(clip.label == "unlabelled");
      REQUIRE(clip.revision > 0);
      REQUIRE(clip.title.empty());
      REQUIRE(clip.edit_time_us == 0);
      const auto segments = Require(store->annotations().ListSegments("walks", clip.id));
      REQUIRE(segments.size() == 1);
      REQUIRE(segments[0].id == storage::kLabelSegment);
      REQUIRE(segments[0].track == storage::kActionTrack);
      REQUIRE(segments[0].label == clip.label);
      REQUIRE(segments[0].source == storage::SegmentSource::kImport);
      REQUIRE(segments[0].create_time_us == clip.create_time_us);
      REQUIRE(segments[0].revision == clip.revision);
      REQUIRE_FALSE(segments[0].end_seconds);
      const auto matches =
          Require(store->annotations().SearchClips("walks", clip.id + " unlabelled"));
      REQUIRE(matches.size() == 1);
      REQUIRE(matches[0].clip == clip.id);
    }
    const auto changes = Require(store->annotations().Changes("walks", 0, 10));
    REQUIRE(changes.size() == 5);
    REQUIRE(std::get<storage::ModelPut>(changes.back().change).version == 3);
    REQUIRE(changes.back().revision == Require(store->annotations().Revision("walks")));
    REQUIRE(Require(store->annotations().Changes("walks", 0, 1)).size() == 2);
    storage::ClipChange relabel;
    relabel.clip = "walk";
    relabel.label = "stroll";
    const auto edit =
        Require(store->annotations().Edit("walks", std::vector<storage::Change>{relabel}, "me"));
    REQUIRE(edit.id == changes.back().revision + 1);
    REQUIRE(Require(store->GetClip("walks", "walk")).label == "stroll");
    // Writing works, also to tables of later versions.
    REQUIRE_OK(store->access().AddToken({.id = "t", .salt = "s", .secret_hash = "h"}));
    REQUIRE_OK(store->DeleteClip("walks", "squat"));
    REQUIRE(Findings(*store).empty());
  }
  REQUIRE(file.Sql("PRAGMA user_version") == std::to_string(storage::Migrations().size()));
  REQUIRE(file.Sql("PRAGMA integrity_check") == "ok");
}

TEST_CASE("SqliteMotionStore: the words of version 10 are normalised again",
          "[storage][migration]") {
  const StoreFile file;
  {
    const auto store = file.Open();
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
    auto clip = SampleClip("d", "walk", 1);
    clip.record.title = "Straße Шёлк";
    REQUIRE_OK(store->AddClip(clip));
  }
  file.Sql(
      "UPDATE clip_text SET title = 'straße шёлк'; DROP TABLE build_lease; "
      "DROP INDEX unfinished_operation; PRAGMA user_version = 10");
  SECTION("also of a corrupt index") {
    CorruptPage(file.path(), std::stol(file.Sql(RootPageOf("clip_text_content"))));
  }
  const auto store = file.Open();
  REQUIRE(Require(store->SearchClips("d", "STRASSE шелк")).size() == 1);
  REQUIRE(Findings(*store).empty());
}

TEST_CASE("ReadStoreVersion: before and after an upgrade, also if it is only in the log",
          "[storage][migration]") {
  const auto latest = static_cast<int>(storage::Migrations().size());
  const StoreFile file;
  CHECK(Require(storage::ReadStoreVersion(file.path())) == 0);
  CHECK(std::filesystem::is_empty(file.folder()));
  std::ofstream(file.path(), std::ios::binary).flush();
  CHECK(Require(storage::ReadStoreVersion(file.path())) == 0);
  std::ofstream(file.path(), std::ios::binary) << OldStore(2);
  CHECK(Require(storage::ReadStoreVersion(file.path())) == 2);
  {
    // The files after a kill that follows the upgrade.
    const StoreFile killed;
    std::filesystem::copy_file(file.path(), killed.path());
    const auto store = file.Open();
    std::filesystem::copy_file(file.path() + "-wal", killed.path() + "-wal");
    CHECK(Require(storage::ReadStoreVersion(killed.path())) == latest);
    REQUIRE(Findings(*killed.Open()).empty());
  }
  CHECK(Require(storage::ReadStoreVersion(file.path())) == latest);
}

TEST_CASE("SqliteMotionStore: there is a test store of every former version",
          "[storage][migration]") {
  for (int version = 1; version < static_cast<int>(storage::Migrations().size()); ++version) {
    REQUIRE_FALSE(OldStore(version).empty());
  }
}

}  // namespace motiondb::tests::old_stores_test
