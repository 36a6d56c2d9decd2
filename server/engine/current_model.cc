// The models with which an Engine answers queries, and which of them stay in memory.
#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "server/engine/engine.h"
#include "server/engine/work/work_options.h"

namespace motiondb::server {

absl::StatusOr<SnapshotPointer> Engine::CurrentModel(const LiveDatabase& database,
                                                     const WorkOptions& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(ServedModel served, CurrentModelAndRevision(database, terms));
  return std::move(served.snapshot);
}

absl::StatusOr<ServedModel> Engine::CurrentModelAndRevision(const LiveDatabase& database,
                                                            const WorkOptions& terms) {
  auto served = database.lifecycle().Use();
  if (IsAwaitingChange(served.status()) && terms.wake_on) {
    terms.wake_on(*database.signal());
    served = database.lifecycle().Use();  // the change may have come before
  }
  if (!served.ok() || served->snapshot != nullptr) return served;
  if (const std::string operation = database.lifecycle().operation(); !operation.empty()) {
    return core::WithResource(
        "operation", fmt::format("operations/{}", operation),
        core::WithReason("MODEL_BUILDING",
                         core::FailedPrecondition("database '{}' has no model yet; its first "
                                                  "model is being built: wait for operations/{}",
                                                  database.name(), operation)));
  }
  if (database.stored().clip_count > 0) {
    return core::WithReason(
        "NO_MODEL",
        core::FailedPrecondition("database '{}' has clips but no model: the build failed or was "
                                 "cancelled; start it again (motiondb reprocess {})",
                                 database.name(), database.name()));
  }
  return core::WithReason(
      "NO_MODEL",
      core::FailedPrecondition(
          "database '{}' has no model yet: ingest clips first (motiondb ingest {} FILE...)",
          database.name(), database.name()));
}

absl::StatusOr<SnapshotPointer> Engine::ModelIfAny(const LiveDatabase& database,
                                                   const WorkOptions& terms) {
  if (database.lifecycle().served().record() == nullptr) return SnapshotPointer();
  return CurrentModel(database, terms);
}

void Engine::MakeRoom(std::int64_t bytes) {
  struct Loaded {
    Executor::Clock::time_point last_use;
    std::int64_t bytes = 0;
    std::shared_ptr<LiveDatabase> database;
  };
  std::vector<Loaded> models;
  for (const auto& live : Databases()) {
    const std::int64_t size = live->lifecycle().model_bytes();
    bytes += size;
    if (size > 0) models.push_back({live->lifecycle().last_use(), size, live});
  }
  std::ranges::sort(models, {}, &Loaded::last_use);
  for (std::size_t i = 0; i + 1 < models.size() && bytes > options_.model_memory_bytes; ++i) {
    ModelLifecycle& lifecycle = models[i].database->lifecycle();
    if (lifecycle.Evict()) {
      bytes -= models[i].bytes;
    } else if (lifecycle.IsUpdating()) {
      return;  // rather than evicting a model that was used later
    }
  }
}

}  // namespace motiondb::server
