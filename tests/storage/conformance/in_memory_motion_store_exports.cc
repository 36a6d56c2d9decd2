// Export and import of the store in memory.
#include <memory>
#include <utility>
#include <variant>

#include "core/motion/error.h"
#include "tests/storage/conformance/in_memory_motion_store.h"

namespace motiondb::tests {

// A copy of a database, which an import takes by its name in `all`.
struct InMemoryExport {
  InMemoryMotionStore::Database database;
};

namespace {

std::mutex exports_mutex;

// All exports of this process, by their bytes.
std::map<std::string, std::shared_ptr<const InMemoryExport>>& Exports() {
  static std::map<std::string, std::shared_ptr<const InMemoryExport>> exports;
  return exports;
}

class ExportedName final : public storage::StoreBackup {
 public:
  explicit ExportedName(std::string name) : name_(std::move(name)) {}
  std::int64_t total_bytes() const override { return std::ssize(name_); }
  absl::StatusOr<bool> Read(std::string& block) override {
    block = name_;
    return !std::exchange(is_read_, true);
  }

 private:
  const std::string name_;
  bool is_read_ = false;
};

}  // namespace

class InMemoryImport final : public storage::DatabaseImport {
 public:
  explicit InMemoryImport(InMemoryMotionStore& store) : store_(store) {}
  absl::Status Append(std::string_view bytes) override {
    received_ += bytes;
    return absl::OkStatus();
  }
  absl::StatusOr<storage::ExportedDatabase> Check(const core::Cancelled&) override {
    const std::lock_guard lock(exports_mutex);
    const auto found = Exports().find(received_);
    if (found == Exports().end()) return core::InvalidArgument("not an exported database");
    checked_ = found->second;
    storage::ExportedDatabase content;
    content.record = checked_->database.record;
    for (const auto& [id, clip] : checked_->database.clips) {
      ++content.clip_count;
      content.frame_count += clip.record.frame_count;
      content.byte_count += clip.record.byte_count;
    }
    return content;
  }
  absl::Status Stage(const core::Cancelled&) override {
    if (checked_ == nullptr) return core::FailedPrecondition("the export was not checked");
    staged_ = std::move(checked_);
    return absl::OkStatus();
  }
  absl::Status Publish(const std::string& database, const storage::WriteOptions& terms) override {
    if (staged_ == nullptr) return core::FailedPrecondition("the export was not staged");
    MOTIONDB_RETURN_IF_ERROR(store_.AddCopy(staged_->database, database, terms));
    staged_ = nullptr;
    return absl::OkStatus();
  }

 private:
  InMemoryMotionStore& store_;
  std::string received_;
  std::shared_ptr<const InMemoryExport> checked_, staged_;
};

absl::StatusOr<std::unique_ptr<storage::StoreBackup>> InMemoryMaintenance::BeginExport(
    const std::string& database, const core::Cancelled&) {
  const std::lock_guard lock(store_.mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const InMemoryMotionStore::Database* const in, store_.Find(database));
  const std::lock_guard exports_lock(exports_mutex);
  const std::string name = fmt::format("export {} of {}", Exports().size(), database);
  Exports()[name] = std::make_shared<const InMemoryExport>(InMemoryExport{*in});
  return std::make_unique<ExportedName>(name);
}

absl::StatusOr<std::unique_ptr<storage::DatabaseImport>> InMemoryMaintenance::BeginImport() {
  return std::make_unique<InMemoryImport>(store_);
}

absl::Status InMemoryMotionStore::AddCopy(Database copy, const std::string& name,
                                          const storage::WriteOptions& terms) {
  const std::lock_guard lock(mutex_);
  if (databases_.contains(name)) {
    return absl::AlreadyExistsError(fmt::format("database '{}' already exists", name));
  }
  const auto rename = [&](std::optional<storage::EditedState>& state) {
    if (state) std::visit([&](auto& record) { record.database = name; }, *state);
  };
  copy.record.name = name;
  for (auto& [id, clip] : copy.clips) clip.record.database = name;
  for (storage::NewClip& clip : copy.deleted) clip.record.database = name;
  for (auto& [clip, segments] : copy.segments) {
    for (storage::SegmentRecord& segment : segments) segment.database = name;
  }
  for (storage::EditRecord& edit : copy.edits) {
    edit.database = name;
    for (storage::EditedObject& object : edit.objects) {
      rename(object.before);
      rename(object.after);
    }
  }
  for (storage::ModelRecord& model : copy.models) model.database = name;
  copy.id = copy.record.id = ++last_id_;
  copy.lease_holder.clear();
  copy.last_fence = 0;
  databases_[name] = std::move(copy);
  return Note(terms);
}

}  // namespace motiondb::tests
