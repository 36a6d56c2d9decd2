// Disk faults at every write and sync of each kind of change: acknowledged changes stay, others
// leave no trace, and nothing is corrupt.
#include <catch2/catch.hpp>
#include <functional>
#include <string>
#include <vector>

#include "core/model/model_builder.h"
#include "tests/storage/backup_bytes.h"
#include "tests/storage/faults/fault_run.h"
#include "tests/storage/old_store.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::power_cut_test {
namespace {

using Store = storage::MotionStore;

// Returns the bytes of a store with the content that `fill` adds.
std::string FileOf(const std::function<void(Store&)>& fill) {
  const StoreFile file;
  fill(*file.Open(FaultOptions("")));
  return ReadFile(file.path());
}

void FillWithModel(Store& store) {
  REQUIRE_OK(store.CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store.AddClip(SampleClip("d", "walk", 1)));
  REQUIRE_OK(store.AddClip(SampleClip("d", "run", 2)));
  REQUIRE_OK(store.PutModel("d", SampleModel({SampleClip("d", "walk", 1)})));
  REQUIRE_OK(store.PutOperation(SampleOperation("d", "first")));
}

core::Model Extended() {
  const auto run = SampleClip("d", "run", 2);
  std::vector<core::BuildInput> inputs;
  inputs.push_back({run.record.id, run.record.label, run.states, run.record.subject});
  return Require(core::ExtendModel(SampleModel({SampleClip("d", "walk", 1)}), std::move(inputs),
                                   core::RunSerially));
}

// The audit entry of a change: stored with the change, or neither is stored.
const storage::AuditRecord kEntry{.time_us = kFaultTime, .method = "Change"};

void RunAll(FaultyChange change, bool is_seen = true) {
  FaultRun run(std::move(change));
  REQUIRE(run.is_seen() == is_seen);
  run.CutPowerEverywhere();
  run.FailEverywhere();
  run.FillEverywhere();
  REQUIRE(run.cases() * FaultRun::Variable("MOTIONDB_FAULT_STRIDE", 1) *
              FaultRun::Variable("MOTIONDB_FAULT_PARTS", 1) >
          100);
}

}  // namespace

TEST_CASE("Faults: creation of a store", "[storage][power]") {
  RunAll({"", [](Store& store) { return store.CreateDatabase(SampleDatabase("d"), {&kEntry}); }});
}

TEST_CASE("Faults: an ingest", "[storage][power]") {
  auto clip = SampleClip("d", "jump", 3);
  clip.skeleton = SampleSkeleton("other");
  clip.audit = [](const storage::ClipRecord& stored) {
    auto entry = kEntry;
    entry.resource = stored.id;
    return entry;
  };
  RunAll({FileOf(FillWithModel), [clip](Store& store) { return store.AddClip(clip).status(); }});
}

TEST_CASE("Faults: an edit", "[storage][power]") {
  std::vector<storage::Change> changes;
  storage::ClipChange title;
  title.clip = "walk";
  title.title = "Title";
  changes.emplace_back(title);
  storage::SegmentCreation segment;
  segment.segment.clip = "walk";
  segment.segment.id = "step";
  segment.segment.end_seconds = 0.5;
  changes.emplace_back(segment);
  RunAll({FileOf(FillWithModel), [changes](Store& store) {
            return store.annotations().Edit("d", changes, "me", {&kEntry}).status();
          }});
}

TEST_CASE("Faults: a rebuild", "[storage][power]") {
  const core::Model model = SampleModel({SampleClip("d", "run", 2), SampleClip("d", "walk", 1)});
  RunAll({FileOf(FillWithModel),
          [model](Store& store) { return store.PutModel("d", model).status(); }});
}

TEST_CASE("Faults: results of deriving clips again", "[storage][power]") {
  const auto derived = [](Store& store) {
    storage::DerivedClip walk{.record = Require(store.GetClip("d", "walk")),
                              .states = SampleStates(50, 9)};
    walk.record.frame_count = 50;
    walk.record.source_report = "derived again";
    storage::DerivedClip run{.record = Require(store.GetClip("d", "run"))};
    run.record.derive_error = "cannot be read";
    return std::vector{walk, run};
  };
  std::vector<storage::DerivedClip> clips;
  const std::string before = FileOf([&](Store& store) {
    FillWithModel(store);
    clips = derived(store);
  });
  // The current model keeps the replaced states.
  const auto rest = [](Store& store, const StoreFile&) {
    REQUIRE(Same(Require(store.ReadModel("d", core::RunSerially)),
                 SampleModel({SampleClip("d", "walk", 1)})));
  };
  RunAll({before, [clips](Store& store) { return store.PutDerived("d", clips).status(); }, rest});
}

TEST_CASE("Faults: dropping a model", "[storage][power]") {
  // Only the model uses the deleted clip.
  const auto fill = [](Store& store) {
    FillWithModel(store);
    REQUIRE_OK(store.DeleteClip("d", "walk"));
  };
  const auto rest = [](Store& store, const StoreFile& file) {
    REQUIRE_OK(store.DropModel("d"));
    REQUIRE(file.Sql("SELECT count(DISTINCT clip_key) FROM clip_chunk") == "1");
    REQUIRE(Findings(store).empty());
  };
  RunAll({FileOf(fill), [](Store& store) { return store.DropModel("d"); }, rest});
}

TEST_CASE("Faults: the end of an operation", "[storage][power]") {
  auto ended = SampleOperation("d", "first");
  ended.state = storage::OperationState::kSucceeded;
  ended.progress = 1;
  ended.stage = "done";
  ended.model_version = 1;
  ended.update_time_us = kFaultTime + 1;
  RunAll({FileOf(FillWithModel), [ended](Store& store) { return store.PutOperation(ended); }});
}

TEST_CASE("Faults: an extension", "[storage][power]") {
  const core::Model model = Extended();
  RunAll({FileOf(FillWithModel),
          [model](Store& store) { return store.PutExtension("d", model, 0.1).status(); }});
}

TEST_CASE("Faults: deletion", "[storage][power]") {
  SECTION("of a clip that the model uses") {
    RunAll({FileOf(FillWithModel),
            [](Store& store) { return store.DeleteClip("d", "walk", {&kEntry}).status(); }});
  }
  SECTION("of a clip that the model does not use") {
    RunAll({FileOf(FillWithModel),
            [](Store& store) { return store.DeleteClip("d", "run", {&kEntry}).status(); }});
  }
  SECTION("of a database") {
    RunAll(
        {FileOf(FillWithModel), [](Store& store) { return store.DeleteDatabase("d", {&kEntry}); }});
  }
  SECTION("of the content of a deleted database") {
    const auto fill = [](Store& store) {
      FillWithModel(store);
      REQUIRE_OK(store.DeleteDatabase("d", {&kEntry}));
      REQUIRE_OK(store.CreateDatabase(SampleDatabase("d")));
      REQUIRE_OK(store.AddClip(SampleClip("d", "jump", 3)));
    };
    const auto rest = [](Store& store, const StoreFile& file) {
      REQUIRE_OK(store.PurgeDeletedDatabases({}));
      REQUIRE(file.Sql("SELECT count(*) FROM database") == "1");
      REQUIRE(file.Sql("SELECT count(DISTINCT clip_key) FROM clip_chunk") == "1");
      REQUIRE(Findings(store).empty());
    };
    RunAll({FileOf(fill), [](Store& store) { return store.PurgeDeletedDatabases({}); }, rest},
           /*is_seen=*/false);
  }
}

TEST_CASE("Faults: a restore", "[storage][power]") {
  const StoreFile from;
  const auto source = from.Open(FaultOptions(""));
  FillWithModel(*source);
  const std::string backup = Backup(*source);
  // The token and the audit entry of the target stay.
  const auto fill = [](Store& store) {
    REQUIRE_OK(store.access().AddToken({.id = "t", .salt = "s", .secret_hash = "h"}, {&kEntry}));
  };
  RunAll({FileOf(fill), [&](Store& store) { return Restore(store, backup); }});
}

TEST_CASE("Faults: an import", "[storage][power]") {
  const StoreFile from;
  const auto source = from.Open(FaultOptions(""));
  FillWithModel(*source);
  const std::string exported = Export(*source, "d");
  const auto rest = [](Store& store, const StoreFile& file) {
    REQUIRE_OK(store.PurgeDeletedDatabases({}));
    const bool is_imported = store.GetDatabase("copy").ok();
    REQUIRE(file.Sql("SELECT count(*) FROM database") == (is_imported ? "2" : "1"));
    REQUIRE(file.Sql("SELECT count(DISTINCT clip_key) FROM clip_chunk") ==
            file.Sql("SELECT count(*) FROM clip"));
    REQUIRE(Findings(store).empty());
  };
  RunAll({FileOf(FillWithModel),
          [&](Store& store) { return Import(store, exported, "copy", &kEntry); }, rest});
}

TEST_CASE("Faults: a token", "[storage][power]") {
  const auto add = [](Store& store) {
    return store.access().AddToken({.id = "t", .salt = "s", .secret_hash = "h"}, {&kEntry});
  };
  SECTION("that is created") { RunAll({FileOf(FillWithModel), add}); }
  SECTION("that is revoked") {
    const auto fill = [add](Store& store) {
      FillWithModel(store);
      REQUIRE_OK(add(store));
    };
    RunAll({FileOf(fill), [](Store& store) {
              return store.access().RevokeToken("t", kFaultTime, {&kEntry}).status();
            }});
  }
}

TEST_CASE("Faults: a migration", "[storage][power][migration]") {
  const int version = GENERATE(1, 2, 3, 7, 10, 11);
  RunAll({OldStore(version), [](Store&) { return absl::OkStatus(); }}, /*is_seen=*/false);
}

}  // namespace motiondb::tests::power_cut_test
