#include "tests/storage/conformance/motion_store_conformance.h"

#include <string>
#include <vector>

#include "tests/storage/conformance/access_store_conformance.h"
#include "tests/storage/conformance/annotation_conformance.h"
#include "tests/storage/conformance/build_lease_conformance.h"
#include "tests/storage/conformance/clip_conformance.h"
#include "tests/storage/conformance/exported_database_conformance.h"
#include "tests/storage/conformance/model_conformance.h"
#include "tests/storage/conformance/recreated_database_conformance.h"
#include "tests/storage/faults/store_pages.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"

namespace motiondb::tests {
namespace {

using absl::StatusCode;
using storage::NewClip;

void TestDatabases(StoreUnderTest& store) {
  const auto record = SampleDatabase("walks");
  REQUIRE_OK(store->CreateDatabase(record));
  REQUIRE(Same(Require(store->GetDatabase("walks")), record));
  REQUIRE_ERROR(store->CreateDatabase(record), StatusCode::kAlreadyExists, "walks");
  REQUIRE_ERROR(store->GetDatabase(kUnknown), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->DeleteDatabase(kUnknown), StatusCode::kNotFound, kUnknown);

  auto other = SampleDatabase("box es/%'\"\xc3\xa9");  // a store accepts any name
  other.settings = {.frame_rate_hz = 29.97, .min_frames = 16, .scaling = core::Scaling::kNone};
  other.marker_set_text = std::string("line\r\n\0more", 11);
  REQUIRE_OK(store->CreateDatabase(other));
  REQUIRE(Same(Require(store->GetDatabase(other.name)), other));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("Zumba")));
  const std::vector<std::string> names{"Zumba", other.name, "walks"};
  for (const int limit : {1, 2, 3, 10}) {
    REQUIRE(names == AllPages(
                         limit,
                         [&](const storage::Page& page) { return store->ListDatabases(page); },
                         [](const auto& database) { return database.name; }));
  }

  REQUIRE_ERROR(store->ReplaceMarkerSet(kUnknown, "", "new"), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->ReplaceMarkerSet(other.name, "line", "new"), StatusCode::kAborted, "set");
  REQUIRE_OK(store->ReplaceMarkerSet(other.name, other.marker_set_text, "new"));
  other.marker_set_text = "new";
  REQUIRE(Same(Require(store->GetDatabase(other.name)), other));
  REQUIRE(Same(Require(store->GetDatabase("walks")), record));

  REQUIRE_OK(store->DeleteDatabase("walks"));
  REQUIRE_ERROR(store->GetDatabase("walks"), StatusCode::kNotFound, "walks");
  REQUIRE_OK(store->CreateDatabase(record));
}

void TestDeleteDatabaseWithAll(StoreUnderTest& store) {
  for (const char* name : {"a", "b"}) {
    REQUIRE_OK(store->CreateDatabase(SampleDatabase(name)));
    const NewClip clip = SampleClip(name, "walk", 1);
    REQUIRE_OK(store->AddClip(clip));
    REQUIRE_OK(store->PutModel(name, SampleModel({clip})));
    REQUIRE_OK(store->PutOperation(SampleOperation(name, std::string("op-") + name)));
  }
  REQUIRE_OK(store->DeleteDatabase("a"));
  if (GENERATE(true, false)) REQUIRE_OK(store->PurgeDeletedDatabases({}));
  REQUIRE_ERROR(store->GetClip("a", "walk"), StatusCode::kNotFound, "a");
  REQUIRE_ERROR(store->ReadModel("a", core::RunSerially), StatusCode::kNotFound, "a");
  REQUIRE_ERROR(store->GetOperation("op-a"), StatusCode::kNotFound, "op-a");
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("a")));
  REQUIRE(ClipIds(store, "a", 10).empty());
  REQUIRE(Require(store->ListModels("a", 0, 10)).empty());
  REQUIRE(Require(store->ListSkeletons("a", {})).empty());
  REQUIRE(Require(store->ListOperations("a", "", 10)).empty());

  REQUIRE(Require(store->GetClip("b", "walk")).id == "walk");
  REQUIRE_OK(store->ReadModel("b", core::RunSerially));
  REQUIRE_OK(store->GetOperation("op-b"));
  REQUIRE(Require(store->ListOperations("", "", 10)).size() == 1);
}

void TestOperations(StoreUnderTest& store) {
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d")));
  REQUIRE_OK(store->CreateDatabase(SampleDatabase("e")));
  REQUIRE_ERROR(store->GetOperation(kUnknown), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->PutOperation(SampleOperation(kUnknown, "x")), StatusCode::kNotFound,
                kUnknown);
  REQUIRE_ERROR(store->ListOperations(kUnknown, "", 10), StatusCode::kNotFound, kUnknown);
  REQUIRE_ERROR(store->ListOperations("", kUnknown, 10), StatusCode::kNotFound, kUnknown);

  // Operations are ordered by creation, not by id or time.
  for (const char* id : {"m", "z", "a", "k"}) {
    auto record = SampleOperation(*id == 'k' ? "e" : "d", id);
    if (*id == 'z') record.kind = storage::OperationKind::kReprocess;
    REQUIRE_OK(store->PutOperation(record));
  }
  auto changed = SampleOperation("d", "z");
  changed.state = storage::OperationState::kFailed;
  changed.kind = storage::OperationKind::kReprocess;
  changed.progress = 0.5;
  changed.stage = "tree, layer 3";
  changed.model_version = 4;
  changed.error_code = 8;
  changed.error_message = "disk full";
  changed.update_time_us += 10;
  REQUIRE_OK(store->PutOperation(changed));
  REQUIRE(Same(Require(store->GetOperation("z")), changed));
  REQUIRE(Same(Require(store->GetOperation("m")), SampleOperation("d", "m")));

  const auto ids = [&](const std::string& database, const std::string& before, int limit) {
    std::string joined;
    for (const auto& record : Require(store->ListOperations(database, before, limit))) {
      joined += record.id;
    }
    return joined;
  };
  // Unfinished ones are listed in order of creation; those that have ended keep their state.
  std::string unfinished;
  for (const auto& record : Require(store->ListUnfinishedOperations())) unfinished += record.id;
  REQUIRE(unfinished == "mak");
  auto late = changed;
  late.state = storage::OperationState::kRunning;
  REQUIRE_ERROR(store->PutOperation(late), StatusCode::kAborted, "ended");
  late.state = storage::OperationState::kCancelled;
  REQUIRE_ERROR(store->PutOperation(late), StatusCode::kAborted, "ended");
  late = changed;
  late.model_version = 5;
  REQUIRE_ERROR(store->PutOperation(late), StatusCode::kAborted, "ended");
  REQUIRE(Same(Require(store->GetOperation("z")), changed));

  REQUIRE(ids("", "", 10) == "kazm");
  REQUIRE(ids("", "", 2) == "ka");
  REQUIRE(ids("", "a", 10) == "zm");
  REQUIRE(ids("", "m", 10).empty());
  REQUIRE(ids("d", "", 10) == "azm");
  REQUIRE(ids("d", "z", 10) == "m");
  REQUIRE(ids("e", "", 10) == "k");
  REQUIRE(Same(Require(store->ListOperations("d", "a", 1)).at(0), changed));
}

}  // namespace

void TestMotionStore(const std::function<std::unique_ptr<StoreUnderTest>()>& make) {
  const auto store = make();
  SECTION("databases are stored") { TestDatabases(*store); }
  SECTION("a database is deleted with its content") { TestDeleteDatabaseWithAll(*store); }
  SECTION("clips are stored") { TestClips(*store); }
  SECTION("clips are replaced") { TestReplacedClips(*store); }
  SECTION("results of deriving clips again are stored") { TestDerivedClips(*store); }
  SECTION("the first clip can set the marker set") { TestMarkerSetOfFirstClip(*store); }
  SECTION("identical skeletons are stored once") { TestSkeletons(*store); }
  SECTION("models are stored") { TestModels(*store); }
  SECTION("leases order the models of several builders") { TestBuildLeases(*store); }
  SECTION("random builders have the effect that a simple model has") {
    TestRandomBuilders(*store, 1, 80);
  }
  SECTION("a model is read from the one that it extends") { TestReadExtension(*store); }
  SECTION("states of databases tell what has changed") { TestDatabaseStates(*store); }
  SECTION("a database that is created again is another one") { TestRecreatedDatabase(*store); }
  SECTION("operations are stored and listed newest first") { TestOperations(*store); }
  SECTION("segments are edited") { TestSegments(*store); }
  SECTION("a label is a segment") { TestLabels(*store); }
  SECTION("segments are stored with a new clip") { TestSegmentsOfNewClips(*store); }
  SECTION("edits are kept and listed newest first") { TestEdits(*store); }
  SECTION("edits are undone") { TestUndo(*store); }
  SECTION("annotations are kept") { TestKeptAnnotations(*store); }
  SECTION("clips are found by words") { TestTextSearch(*store); }
  SECTION("changes are listed") { TestChanges(*store); }
  SECTION("random edits have the effect that a simple model has") {
    TestRandomEdits(*store, 1, 60);
  }
  SECTION("replicas follow random changes") { TestReplicas(*store, 1, 60); }
  SECTION("a database is exported and imported") { TestExportedDatabases(*store); }
  SECTION("tokens are stored") { TestTokens(*store); }
  SECTION("audit entries are stored and listed newest first") { TestAudit(*store); }
  SECTION("an audit entry is stored only with its change") { TestAuditOfChanges(*store); }
}

}  // namespace motiondb::tests
