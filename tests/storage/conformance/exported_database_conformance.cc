#include "tests/storage/conformance/exported_database_conformance.h"

#include <string>
#include <utility>
#include <vector>

#include "core/model/model_builder.h"
#include "tests/storage/backup_bytes.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"
#include "tests/storage/store_dump.h"

namespace motiondb::tests {
namespace {

using absl::StatusCode;

// Returns the changes of a database from the beginning, as lines.
std::string DumpChanges(storage::MotionStore& store, const std::string& database) {
  std::string text;
  for (const auto& record : Require(store.annotations().Changes(database, 0, 1000))) {
    text += std::to_string(record.revision) + " " + std::to_string(record.change.index());
    if (const auto* put = std::get_if<storage::ClipPut>(&record.change)) text += put->clip.id;
    if (const auto* put = std::get_if<storage::SegmentPut>(&record.change)) text += put->segment.id;
    if (const auto* put = std::get_if<storage::ModelPut>(&record.change)) {
      text += std::to_string(put->version);
    }
    if (const auto* gone = std::get_if<storage::Deleted>(&record.change)) {
      text += gone->clip + "/" + gone->segment;
    }
    text += "\n";
  }
  return text;
}

std::vector<std::string> Found(storage::MotionStore& store, const std::string& database,
                               const std::string& query) {
  std::vector<std::string> clips;
  for (const auto& match : Require(store.annotations().SearchClips(database, query))) {
    clips.push_back(match.clip);
  }
  std::ranges::sort(clips);
  return clips;
}

void RequireSameDatabase(storage::MotionStore& a, const std::string& in_a, storage::MotionStore& b,
                         const std::string& in_b) {
  auto record = Require(b.GetDatabase(in_b));
  record.name = in_a;
  REQUIRE(Same(Require(a.GetDatabase(in_a)), record));
  REQUIRE(DumpDatabase(a, in_a) == DumpDatabase(b, in_b));
  REQUIRE(DumpChanges(a, in_a) == DumpChanges(b, in_b));
  REQUIRE(Require(a.annotations().Revision(in_a)) == Require(b.annotations().Revision(in_b)));
  for (const char* const query : {"walk", "title", "wal*", "\"a title\"", "gone"}) {
    REQUIRE(Found(a, in_a, query) == Found(b, in_b, query));
  }
}

}  // namespace

void FillWithEverything(storage::MotionStore& store, const std::string& database) {
  const auto sample = [&](const std::string& id, unsigned seed) {
    return SampleClip(database, id, seed);
  };
  REQUIRE_OK(store.CreateDatabase(SampleDatabase(database)));
  auto walk = sample("walk", 1);
  walk.record.tags = {"outdoor"};
  walk.record.fields["speed"] = 1.5;
  REQUIRE_OK(store.AddClip(walk));
  for (const auto& clip : {sample("run", 2), sample("gone", 3), sample("old", 4)}) {
    REQUIRE_OK(store.AddClip(clip));
  }
  REQUIRE_OK(store.PutModel(database, SampleModel({walk})));
  const core::Model model = SampleModel({walk, sample("gone", 3), sample("old", 4)});
  REQUIRE_OK(store.PutModel(database, model));
  const auto run = sample("run", 2);
  std::vector<core::BuildInput> inputs;
  inputs.push_back({run.record.id, run.record.label, run.states, run.record.subject});
  REQUIRE_OK(store.PutExtension(
      database, Require(core::ExtendModel(model, std::move(inputs), core::RunSerially)), 0.1));
  REQUIRE_OK(store.DeleteClip(database, "gone"));
  REQUIRE_OK(store.ReplaceClip(Require(store.GetClip(database, "old")), sample("old", 5)));
  storage::ClipChange title;
  title.clip = "walk";
  title.title = "A title";
  title.label = "stroll";
  storage::SegmentCreation carries;
  carries.segment = {.clip = "walk", .id = "s", .track = "carries", .label = "box"};
  carries.segment.start_seconds = 0.1;
  auto brief = carries;
  brief.segment.id = "brief";
  brief.segment.track = "other";
  auto& annotations = store.annotations();
  REQUIRE_OK(annotations.Edit(database, std::vector<storage::Change>{title, carries, brief}, "me"));
  REQUIRE_OK(annotations.Edit(
      database, std::vector<storage::Change>{storage::SegmentDeletion{"walk", "brief"}}, "you"));
  REQUIRE_OK(store.PutOperation(SampleOperation(database, database + "-op")));
}

void TestExportedDatabases(StoreUnderTest& under_test) {
  storage::MotionStore& store = under_test.Get();
  const absl::Status supported = store.maintenance().BeginImport().status();
  if (absl::IsFailedPrecondition(supported)) return;  // a store in memory
  FillWithEverything(store, "d");
  FillWithEverything(store, "other");
  REQUIRE_ERROR(store.maintenance().BeginExport(kUnknown, {}), StatusCode::kNotFound, kUnknown);
  const std::string bytes = Export(store, "d");

  const auto import = Require(store.maintenance().BeginImport());
  REQUIRE_ERROR(import->Stage({}), StatusCode::kFailedPrecondition, "not checked");
  for (std::size_t begin = 0; begin < bytes.size(); begin += 100'000) {
    REQUIRE_OK(import->Append(std::string_view(bytes).substr(begin, 100'000)));
  }
  const storage::ExportedDatabase content = Require(import->Check({}));
  REQUIRE(Same(content.record, Require(store.GetDatabase("d"))));
  std::int64_t frames = 0;
  std::int64_t size = 0;
  const auto clips = Require(store.ListClips("d", {}));
  for (const auto& clip : clips) {
    frames += clip.frame_count;
    size += clip.byte_count;
  }
  REQUIRE(content.clip_count == std::ssize(clips));
  REQUIRE(content.frame_count == frames);
  REQUIRE(content.byte_count == size);
  REQUIRE_ERROR(import->Publish("copy"), StatusCode::kFailedPrecondition, "not staged");
  REQUIRE_OK(import->Stage({}));
  REQUIRE_ERROR(import->Stage({}), StatusCode::kFailedPrecondition, "not checked");

  // Hidden, also from a purge, until it is published.
  REQUIRE(Require(store.ListDatabases({})).size() == 2);
  REQUIRE_OK(store.DeleteDatabase("other"));
  REQUIRE_OK(store.PurgeDeletedDatabases({}));
  REQUIRE_ERROR(import->Publish("d"), StatusCode::kAlreadyExists, "'d'");
  const storage::AuditRecord audit{.method = "Import"};
  REQUIRE_OK(import->Publish("copy", {&audit, {}}));
  REQUIRE_ERROR(import->Publish("again"), StatusCode::kFailedPrecondition, "not staged");
  REQUIRE(Require(store.access().ListAuditRecords(0, 1)).at(0).method == "Import");
  REQUIRE_OK(store.PurgeDeletedDatabases({}));
  RequireSameDatabase(store, "d", store, "copy");
  REQUIRE(Require(store.ListOperations("copy", "", 10)).empty());

  // Both go their own ways, and keep their histories.
  const auto last = Require(store.annotations().ListEdits("copy", "", 0, 1)).at(0);
  REQUIRE_OK(store.annotations().UndoEdit("copy", last.id, "me"));
  REQUIRE_OK(store.annotations().GetSegment("copy", "walk", "brief"));
  REQUIRE_ERROR(store.annotations().GetSegment("d", "walk", "brief"), StatusCode::kNotFound, "");
  REQUIRE_OK(store.AddClip(SampleClip("copy", "new", 9)));
  REQUIRE_OK(store.DeleteDatabase("d"));
  REQUIRE_OK(store.PurgeDeletedDatabases({}));
  REQUIRE(Require(store.ListClips("copy", {})).size() == clips.size() + 1);
  REQUIRE_OK(store.ReadModel("copy", core::RunSerially));

  // The export still is what it was. An import that ends early leaves nothing visible.
  REQUIRE_OK(Import(store, bytes, "d"));
  const auto left = Require(store.maintenance().BeginImport());
  REQUIRE_OK(left->Append(bytes));
  REQUIRE_OK(left->Check({}));
  REQUIRE_OK(left->Stage({}));
  REQUIRE(Require(store.ListDatabases({})).size() == 2);
}

}  // namespace motiondb::tests
