// Clips that are replaced, and clips whose states are derived again.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "tests/storage/conformance/clip_conformance.h"
#include "tests/storage/faults/store_pages.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"

namespace motiondb::tests {
namespace {

using absl::StatusCode;
using storage::ClipRecord;
using storage::NewClip;
using Derived = std::vector<storage::DerivedClip>;

// The representation version before the current one.
constexpr int kBefore = core::kRepresentationVersion - 1;

// Returns the record after its states were derived by the current version.
ClipRecord Tried(ClipRecord record) {
  record.representation_version = record.tried_version = core::kRepresentationVersion;
  record.tried_time_us += 5;
  return record;
}

}  // namespace

void TestReplacedClips(StoreUnderTest& store) {
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  const ClipRecord old = Require(store->AddClip(SampleClip("d", "walk", 1)));
  const NewClip run = SampleClip("d", "run", 2);
  const ClipRecord run_record = Require(store->AddClip(run));
  // The same file with other conventions: fewer, different states on another skeleton.
  NewClip next = SampleClip("d", "walk", 1);
  next.record.given.metres_per_unit = 0.02;
  next.record.label = "march";
  next.record.create_time_us += 5;
  next.record.frame_count = 50;
  next.states = SampleStates(50, 7);
  next.record.leg_length_m = next.states.leg_length_m = 1.1;
  next.skeleton = SampleSkeleton("human", 0.5);
  const auto check_run_is_unchanged = [&] {
    REQUIRE(Same(Require(store->GetClip("d", "run")), run_record));
    REQUIRE(Same(Require(store->ReadClipStates("d", "run")), run.states));
    REQUIRE(Require(store->ReadClipSource("d", "run")).file_bytes == run.file_bytes);
  };
  const auto check_walk_is_unchanged = [&] {
    REQUIRE(Same(Require(store->GetClip("d", "walk")), old));
    REQUIRE(Same(Require(store->ReadClipStates("d", "walk")), SampleStates(60, 1)));
    REQUIRE(ClipIds(store, "d", 10) == std::vector<std::string>{"run", "walk"});
  };

  SECTION("the same clip has the same content or the fixed id") {
    REQUIRE(Same(Require(store->FindSameClip(SampleClip("d", "other", 1))), old));
    NewClip other = SampleClip("d", "walk", 3);
    REQUIRE_ERROR(store->FindSameClip(other), StatusCode::kNotFound, "clip");
    other.id_is_fixed = true;
    REQUIRE(Same(Require(store->FindSameClip(other)), old));
    other.record.id = "hop";
    REQUIRE_ERROR(store->FindSameClip(other), StatusCode::kNotFound, "clip");
    NewClip both = SampleClip("d", "run", 1);
    both.id_is_fixed = true;
    REQUIRE(Same(Require(store->FindSameClip(both)), old));

    REQUIRE_OK(store->CreateDatabase(SampleDatabase("e")));
    REQUIRE_ERROR(store->FindSameClip(SampleClip("e", "walk", 1)), StatusCode::kNotFound, "clip");
    REQUIRE_ERROR(store->FindSameClip(SampleClip(kUnknown, "walk", 1)), StatusCode::kNotFound,
                  kUnknown);
    REQUIRE_OK(store->DeleteClip("d", "walk"));
    REQUIRE_ERROR(store->FindSameClip(SampleClip("d", "walk", 1)), StatusCode::kNotFound, "clip");
  }
  SECTION("record, states and files are those of the new clip") {
    const ClipRecord stored = Require(store->ReplaceClip(old, next));
    REQUIRE(Same(stored, Expected(next, "walk", stored.skeleton_id)));
    REQUIRE(Same(Require(store->GetClip("d", "walk")), stored));
    REQUIRE(Same(Require(store->ReadClipStates("d", "walk")), next.states));
    REQUIRE(Require(store->ReadClipSource("d", "walk")).file_bytes == next.file_bytes);
    REQUIRE(Require(store->ReadClipSource("d", "walk")).skeleton_bytes == next.skeleton_bytes);
    REQUIRE(Same(Require(store->GetSkeleton("d", stored.skeleton_id)), *next.skeleton));
    REQUIRE(ClipIds(store, "d", 10) == std::vector<std::string>{"run", "walk"});
    check_run_is_unchanged();

    NewClip elsewhere = next;
    elsewhere.record.database = "e";
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("e")));
    REQUIRE(stored.byte_count == Require(store->AddClip(elsewhere)).byte_count);
    REQUIRE(stored.byte_count < old.byte_count);
  }
  SECTION("the new clip can have another id and other content") {
    NewClip hop = SampleClip("d", "hop", 3);
    REQUIRE(Require(store->ReplaceClip(old, hop)).id == "hop");
    REQUIRE(ClipIds(store, "d", 10) == std::vector<std::string>{"hop", "run"});
    REQUIRE(Same(Require(store->ReadClipStates("d", "hop")), hop.states));
    REQUIRE_ERROR(store->GetClip("d", "walk"), StatusCode::kNotFound, "walk");
    check_run_is_unchanged();
  }
  SECTION("the current model keeps the old states until the next one") {
    const core::Model former = SampleModel({run, SampleClip("d", "walk", 1)});
    REQUIRE_OK(store->PutModel("d", former));
    REQUIRE_OK(store->ReplaceClip(old, next));
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), former));
    const auto staleness = Require(store->FindModelStaleness("d"));
    REQUIRE(staleness.removed == 1);
    REQUIRE(staleness.outdated == 1);  // the model is not extended by a second clip with this id
    REQUIRE(staleness.missing == std::vector<std::string>{"walk"});
    REQUIRE_OK(store->PutModel("d", SampleModel({run, next})));
    REQUIRE(Require(store->FindModelStaleness("d")).empty());
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), SampleModel({run, next})));
  }
  SECTION("a build that began before keeps the old clip, even if only its size changes") {
    const NewClip walk = SampleClip("d", "walk", 1);
    const core::Model built = SampleModel({run, walk});
    NewClip taller = walk;
    taller.record.leg_length_m = taller.states.leg_length_m = 0.95;
    REQUIRE_OK(store->ReplaceClip(old, taller));
    REQUIRE_OK(store->PutModel("d", built));
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), built));
    REQUIRE(Require(store->FindModelStaleness("d")).missing == std::vector<std::string>{"walk"});
  }
  SECTION("a clip that was deleted since it was listed is not replaced") {
    REQUIRE_OK(store->DeleteClip("d", "walk"));
    REQUIRE_ERROR(store->ReplaceClip(old, next), StatusCode::kAborted, "clip");
    REQUIRE(ClipIds(store, "d", 10) == std::vector<std::string>{"run"});
    check_run_is_unchanged();
  }
  SECTION("nor is one that was replaced since then") {
    const ClipRecord stored = Require(store->ReplaceClip(old, next));
    NewClip late = next;
    late.record.label = "late";
    late.record.create_time_us += 5;
    REQUIRE_ERROR(store->ReplaceClip(old, late), StatusCode::kAborted, "clip");
    REQUIRE(Same(Require(store->GetClip("d", "walk")), stored));
    REQUIRE(Same(Require(store->ReadClipStates("d", "walk")), next.states));
    REQUIRE(Require(store->ReplaceClip(stored, late)).label == "late");
  }
  SECTION("either the clip is replaced or nothing changes") {
    NewClip wrong = next;
    wrong.record.frame_count = 7;
    REQUIRE_ERROR(store->ReplaceClip(old, wrong), StatusCode::kInvalidArgument, "walk");
    check_walk_is_unchanged();
    // The content of another clip.
    REQUIRE_ERROR(store->ReplaceClip(old, SampleClip("d", "walk", 2)), StatusCode::kAlreadyExists,
                  "'run'");
    check_walk_is_unchanged();
    check_run_is_unchanged();
  }
  SECTION("the audit entry is stored with the change") {
    next.audit = [](const ClipRecord& stored) {
      return storage::AuditRecord{.method = "Replace", .resource = stored.id};
    };
    REQUIRE_OK(store->ReplaceClip(old, next));
    REQUIRE_ERROR(store->ReplaceClip(old, next), StatusCode::kAborted, "clip");
    const auto entries = Require(store->access().ListAuditRecords(0, 10));
    REQUIRE(entries.size() == 1);
    REQUIRE(entries[0].method == "Replace");
    REQUIRE(entries[0].resource == "walk");
  }
}

void TestDerivedClips(StoreUnderTest& store) {
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  NewClip walk = SampleClip("d", "walk", 1);
  walk.record.representation_version = walk.record.tried_version = kBefore;
  NewClip run = SampleClip("d", "run", 2);
  run.record.representation_version = run.record.tried_version = kBefore;
  run.record.given = {};
  run.record.given_leg_length_m.reset();
  const ClipRecord old_walk = Require(store->AddClip(walk));
  const ClipRecord old_run = Require(store->AddClip(run));
  REQUIRE(Same(Require(store->GetClip("d", "run")), Expected(run, "run", old_run.skeleton_id)));
  const auto staleness = [&] { return Require(store->FindModelStaleness("d")); };
  REQUIRE(staleness().missing.empty());  // no new model contains them
  REQUIRE(staleness().to_derive == 2);
  const core::Model former = SampleModel({run, walk});
  REQUIRE_OK(store->PutModel("d", former));
  REQUIRE(staleness().outdated == 2);
  REQUIRE(staleness().removed == 0);

  // One clip with fewer, different states; one with unchanged states.
  storage::DerivedClip derived{.record = Tried(old_walk), .states = SampleStates(50, 7)};
  derived.record.frame_count = 50;
  derived.record.duration_seconds = 1;
  derived.record.leg_length_m = derived.states->leg_length_m = 0.8;
  derived.record.source_report = "another";
  const storage::DerivedClip same{.record = Tried(old_run)};

  SECTION("the current model does not change, and its staleness is reported") {
    const auto stored = Require(store->PutDerived("d", Derived{derived, same}));
    REQUIRE(stored.size() == 2);
    const ClipRecord now = Require(store->GetClip("d", "walk"));
    REQUIRE(Same(stored[0], now));
    REQUIRE(Same(now, derived.record));
    REQUIRE(Same(Require(store->GetSkeleton("d", now.skeleton_id)), *walk.skeleton));
    REQUIRE(Same(Require(store->ReadClipStates("d", "walk")), *derived.states));
    REQUIRE(Require(store->ReadClipSource("d", "walk")).file_bytes == walk.file_bytes);
    REQUIRE(Require(store->ReadClipSource("d", "walk")).skeleton_bytes == walk.skeleton_bytes);
    REQUIRE(Same(Require(store->GetClip("d", "run")), same.record));
    REQUIRE(Same(Require(store->ReadClipStates("d", "run")), run.states));

    const auto is_former = [&] {
      return Same(Require(store->ReadModel("d", core::RunSerially)), former);
    };
    REQUIRE(is_former());
    REQUIRE_OK(store->PurgeDeletedClips("d"));
    REQUIRE(is_former());
    REQUIRE(staleness().missing == std::vector<std::string>{"walk"});
    REQUIRE(staleness().removed == 1);
    REQUIRE(staleness().outdated == 1);
    REQUIRE(staleness().to_derive == 0);

    NewClip new_walk = walk;
    new_walk.states = *derived.states;
    REQUIRE_OK(store->PutModel("d", SampleModel({run, new_walk})));
    REQUIRE(staleness().empty());
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), SampleModel({run, new_walk})));
  }
  SECTION("a clip that could not be derived is in no new model") {
    storage::DerivedClip failed{.record = old_walk};
    failed.record.tried_version = core::kRepresentationVersion;
    failed.record.derive_error = "walk.amc: the file is corrupt";
    REQUIRE_OK(store->PutDerived("d", Derived{failed, same}));
    REQUIRE(Same(Require(store->GetClip("d", "walk")), failed.record));
    REQUIRE(Same(Require(store->ReadClipStates("d", "walk")), walk.states));
    REQUIRE(staleness().outdated == 1);
    REQUIRE(staleness().to_derive == 0);
    REQUIRE_OK(store->PutModel("d", SampleModel({run})));
    REQUIRE(staleness().empty());
  }
  SECTION("a model keeps the states that it was built from, also after the clip is deleted") {
    // One number of the states changes.
    derived.states = walk.states;
    derived.states->leg_length_m = derived.record.leg_length_m;
    derived.states->states(3, 4) += 1;
    derived.record.frame_count = old_walk.frame_count;
    REQUIRE_OK(store->PutDerived("d", Derived{derived, same}));
    REQUIRE_OK(store->DeleteClip("d", "walk"));
    NewClip new_walk = walk;
    new_walk.states = *derived.states;
    const core::Model built = SampleModel({run, new_walk});
    REQUIRE_OK(store->PutModel("d", built));
    REQUIRE(Same(Require(store->ReadModel("d", core::RunSerially)), built));
  }
  SECTION("clips that were deleted or replaced since they were listed are skipped") {
    REQUIRE_OK(store->DeleteClip("d", "walk"));
    NewClip other = SampleClip("d", "run", 3);
    REQUIRE_OK(store->DeleteClip("d", "run"));
    const ClipRecord other_record = Require(store->AddClip(other));
    REQUIRE(Require(store->PutDerived("d", Derived{derived, same})).empty());
    REQUIRE(ClipIds(store, "d", 10) == std::vector<std::string>{"run"});
    REQUIRE(Same(Require(store->GetClip("d", "run")), other_record));
  }
  SECTION("either all are stored or none") {
    derived.record.frame_count = 7;
    REQUIRE_ERROR(store->PutDerived("d", Derived{same, derived}), StatusCode::kInvalidArgument,
                  "walk");
    REQUIRE(Same(Require(store->GetClip("d", "run")), old_run));
    REQUIRE_ERROR(store->PutDerived(kUnknown, Derived{same}), StatusCode::kNotFound, kUnknown);
  }
}

}  // namespace motiondb::tests
