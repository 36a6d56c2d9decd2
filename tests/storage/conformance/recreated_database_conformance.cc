#include "tests/storage/conformance/recreated_database_conformance.h"

#include <vector>

#include "core/model/model.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"

namespace motiondb::tests {
namespace {

using absl::StatusCode;
using storage::NewClip;

constexpr std::chrono::minutes kLong{10};

NewClip In(std::int64_t database_id, NewClip clip) {
  clip.database_id = database_id;
  return clip;
}

storage::OperationRecord OperationIn(std::int64_t database_id, const std::string& id) {
  storage::OperationRecord operation = SampleOperation("d", id);
  operation.database_id = database_id;
  return operation;
}

std::vector<storage::Change> NewTitle(const std::string& title) {
  storage::ClipChange change{.clip = "walk"};
  change.title = title;
  return {change};
}

std::int64_t IdOf(StoreUnderTest& store) { return Require(store->GetDatabase("d")).id; }

// The calls that change the database `d`, which has the clip `walk`, if its id is `id`.
std::vector<absl::Status> ChangesOf(StoreUnderTest& store, std::int64_t id, std::int64_t edit,
                                    const storage::AuditRecord& entry) {
  const storage::WriteOptions terms{.audit = &entry, .cancelled = {}, .database_id = id};
  const NewClip walk = SampleClip("d", "walk", 1);
  return {
      store->AddClip(In(id, SampleClip("d", "run", 2))).status(),
      store->ReplaceClip(walk.record, In(id, SampleClip("d", "walk", 3))).status(),
      store->ReplaceMarkerSet("d", SampleDatabase("d").marker_set_text, "new", terms),
      store->annotations().Edit("d", NewTitle("second"), "somebody", terms).status(),
      store->annotations().UndoEdit("d", edit, "somebody", terms).status(),
      store->PutOperation(OperationIn(id, "late")),
      store->DeleteClip("d", "walk", terms).status(),
      store->DeleteDatabase("d", terms),
  };
}

}  // namespace

void TestRecreatedDatabase(StoreUnderTest& store) {
  const NewClip walk = SampleClip("d", "walk", 1);
  // Creates the database with a clip and an edit, and returns the edit.
  const auto create = [&] {
    REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
    const std::int64_t id = IdOf(store);  // may open the store again
    REQUIRE_OK(store->AddClip(In(id, walk)));
    return Require(store->annotations().Edit("d", NewTitle("first"), "somebody")).id;
  };
  create();
  const std::int64_t id = IdOf(store);
  REQUIRE(id > 0);
  REQUIRE(Require(store->ListDatabaseStates()).at(0).id == id);
  REQUIRE(Require(store->ListDatabases({})).at(0).id == id);
  REQUIRE_OK(store->PutOperation(SampleOperation("d", "early")));
  REQUIRE(Require(store->GetOperation("early")).database_id == id);
  const std::int64_t fence = Require(store->AcquireBuildLease("d", "a", kLong));
  const core::Model model = SampleModel({walk});

  REQUIRE_OK(store->DeleteDatabase("d"));
  const storage::AuditRecord entry{.method = "Change"};
  for (const absl::Status& changed : ChangesOf(store, id, 1, entry)) {
    CHECK(changed.code() == StatusCode::kNotFound);
  }
  const std::int64_t edit = create();
  REQUIRE(IdOf(store) != id);

  SECTION("changes of the deleted one are refused") {
    const std::int64_t revision = Require(store->annotations().Revision("d"));
    for (const absl::Status& changed : ChangesOf(store, id, edit, entry)) {
      CHECK(changed.code() == StatusCode::kAborted);
    }
    REQUIRE(Require(store->annotations().Revision("d")) == revision);
    REQUIRE(Require(store->GetClip("d", "walk")).title == "first");
    REQUIRE(Require(store->GetDatabase("d")).marker_set_text ==
            SampleDatabase("d").marker_set_text);
    REQUIRE(Require(store->ListOperations("d", "", 10)).empty());
    REQUIRE(Require(store->access().ListAuditRecords(0, 10)).empty());
  }
  SECTION("changes of the new one are made") {
    const std::int64_t new_id = IdOf(store);
    for (const absl::Status& changed : ChangesOf(store, new_id, edit, entry)) {
      // The edit that is undone is no longer the last one.
      if (!absl::IsAborted(changed)) REQUIRE_OK(changed);
    }
    REQUIRE(Require(store->ListDatabaseStates()).empty());
  }
  SECTION("a lease of the deleted one is not valid") {
    const bool has_lease = GENERATE(false, true);
    std::int64_t newer = 0;
    if (has_lease) newer = Require(store->AcquireBuildLease("d", "b", kLong));
    REQUIRE(newer != fence);
    CHECK(store->PutModel("d", model, {0, fence}).status().code() == StatusCode::kAborted);
    CHECK(store->DropModel("d", {0, fence}).code() == StatusCode::kAborted);
    CHECK(store->RenewBuildLease("d", fence, kLong).code() == StatusCode::kAborted);
    REQUIRE(Require(store->ListModels("d", 0, 10)).empty());
    REQUIRE_OK(store->ReleaseBuildLease("d", fence));
    if (!has_lease) newer = Require(store->AcquireBuildLease("d", "b", kLong));
    REQUIRE(store->AcquireBuildLease("d", "a", kLong).status().code() == StatusCode::kAborted);
    REQUIRE_OK(store->PutModel("d", model, {0, newer}));
  }
}

}  // namespace motiondb::tests
