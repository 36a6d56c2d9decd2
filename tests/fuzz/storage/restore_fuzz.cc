// Modified backups, restored to a store. A refused backup leaves the store unchanged; an accepted
// one can be read completely. changed_backup.h describes the input.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include "core/model/model.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/fuzz/server/answer_properties.h"
#include "tests/fuzz/storage/changed_backup.h"
#include "tests/fuzz/support/properties.h"
#include "tests/support/temporary_directory.h"

using namespace motiondb;

namespace {

constexpr std::size_t kBlockBytes = 64 << 10;
constexpr int kMaxRows = 1000;

absl::Status Restore(storage::MotionStore& store, const std::string& backup) {
  const auto restore = store.maintenance().BeginRestore();
  tests::CheckContract(restore.ok(), "a restore begins in a store without databases");
  for (std::size_t begin = 0; begin < backup.size(); begin += kBlockBytes) {
    const absl::Status taken =
        (*restore)->Append(std::string_view(backup).substr(begin, kBlockBytes));
    if (!taken.ok()) return taken;
  }
  const absl::Status checked = (*restore)->Check({});
  if (!checked.ok()) return checked;
  const absl::Status finished = (*restore)->Finish({});
  tests::CheckContract(finished.ok(), "a backup that passes all checks is restored");
  return finished;
}

void HoldsRead(const absl::Status& status) {
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  tests::CheckContract(status.ok(), "restored data can be read");
}

// Returns the value, which must exist.
template <typename T>
T Read(absl::StatusOr<T> result) {
  HoldsRead(result.status());
  return *std::move(result);
}

void ReadAll(storage::MotionStore& store) {
  for (const auto& database : Read(store.ListDatabases({.after = "", .limit = kMaxRows}))) {
    const std::string& name = database.name;
    for (const auto& clip : Read(store.ListClips(name, {.after = "", .limit = kMaxRows}))) {
      Read(store.ReadClipSource(name, clip.id));
      Read(store.ReadClipStates(name, clip.id));
    }
    for (const auto& skeleton : Read(store.ListSkeletons(name, {.after = "", .limit = kMaxRows}))) {
      Read(store.GetSkeleton(name, skeleton.id));
    }
    Read(store.ListModels(name, 0, kMaxRows));
    const auto model = store.ReadModel(name, core::RunSerially);
    if (!absl::IsNotFound(model.status())) HoldsRead(model.status());
  }
  Read(store.ListOperations("", "", kMaxRows));
  Read(store.access().ListTokens("", kMaxRows));
  Read(store.access().ListAuditRecords(0, kMaxRows));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string backup = tests::ChangedBackup(data, size);
  const tests::TemporaryDirectory directory;
  const std::string path = directory / "store.db";
  auto store = storage::SqliteMotionStore::Open(path);
  tests::CheckContract(store.ok(), "a store opens");
  const absl::Status restored = Restore(**store, backup);
  tests::CheckRefusalContract(restored);
  if (restored.ok()) {
    ReadAll(**store);
  } else {
    tests::CheckContract(Read((*store)->ListDatabases({})).empty(),
                         "a refused backup changes nothing");
  }
  store->reset();
  const auto files = std::filesystem::directory_iterator(std::filesystem::path(path).parent_path());
  tests::CheckContract(
      std::ranges::all_of(
          files,
          [](const auto& file) { return file.path().filename().string().starts_with("store.db"); }),
      "nothing else is left in the folder");
  return 0;
}
