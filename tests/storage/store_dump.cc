#include "tests/storage/store_dump.h"

#include <vector>

#include "tests/storage/conformance/annotation_conformance.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"

namespace motiondb::tests {
namespace {

std::string DumpOperation(const storage::OperationRecord& operation) {
  return operation.id + " " + std::to_string(static_cast<int>(operation.state)) + " " +
         std::to_string(operation.progress) + operation.stage + " " +
         std::to_string(operation.model_version) + " " + std::to_string(operation.error_code) +
         operation.error_message + " " + std::to_string(operation.update_time_us);
}

}  // namespace

std::string DumpDatabase(storage::MotionStore& store, const std::string& database) {
  std::string text;
  for (const auto& clip : Require(store.ListClips(database, {}))) {
    const auto source = Require(store.ReadClipSource(database, clip.id));
    text += clip.id + " " + clip.skeleton_id + " " + clip.source_report + clip.derive_error +
            std::to_string(clip.representation_version) + std::to_string(clip.tried_version) + " ";
    text += source.file_bytes + source.skeleton_bytes;
    text += Encoded(Require(store.ReadClipStates(database, clip.id)));
  }
  text += DumpAnnotations(store, database);
  for (const auto& edit : Require(store.annotations().ListEdits(database, "", 0, 1000))) {
    text += std::to_string(edit.id) + edit.author + std::to_string(edit.objects.size());
  }
  text += std::to_string(Require(store.annotations().Changes(database, 0, 1'000'000)).size());
  for (const auto& skeleton : Require(store.ListSkeletons(database, {}))) text += skeleton.id;
  for (const auto& model : Require(store.ListModels(database, 0, 100))) {
    text += std::to_string(model.version) + (model.current ? "*" : "");
  }
  const auto model = store.ReadModel(database, core::RunSerially);
  if (model.ok()) {
    text += Encoded(model->parts());
  } else {
    REQUIRE(absl::IsNotFound(model.status()));
  }
  return text;
}

std::string Dump(storage::MotionStore& store) {
  std::string text;
  for (const auto& database : Require(store.ListDatabases({}))) {
    text += database.name + ":" + DumpDatabase(store, database.name);
  }
  for (const auto& operation : Require(store.ListOperations("", "", 100))) {
    text += DumpOperation(operation);
  }
  for (const auto& token : Require(store.access().ListTokens("", 100))) {
    text += token.id + std::to_string(token.revoke_time_us);
  }
  for (const auto& record : Require(store.access().ListAuditRecords(0, 100))) {
    text += record.request_id + record.method + record.resource;
  }
  return text;
}

std::string Findings(storage::MotionStore& store) {
  const auto verifier = Require(store.maintenance().BeginVerify({}));
  std::vector<storage::Corruption> found;
  while (Require(verifier->Step(found))) REQUIRE(verifier->progress() <= 1);
  std::string text;
  for (const auto& corruption : found)
    text += corruption.resource + ": " + corruption.description + "\n";
  REQUIRE(verifier->totals().corruption_count == static_cast<int>(found.size()));
  return text;
}

}  // namespace motiondb::tests
