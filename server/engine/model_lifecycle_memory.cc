// Which models are in memory: reading stored models, and their eviction
// (EngineOptions::model_memory_bytes).
#include <spdlog/spdlog.h>

#include <numeric>
#include <utility>

#include "core/motion/error.h"
#include "server/engine/live_database.h"
#include "server/engine/model_lifecycle.h"
#include "server/engine/operator_log.h"
#include "server/engine/work/engine_options.h"
#include "server/engine/work/work_options.h"
#include "storage/motion_store.h"

namespace motiondb::server {
namespace {

using storage::MutexLock;

// Time for which an error of reading a model is returned, instead of reading it for each query.
constexpr std::chrono::milliseconds kErrorTime{1000};

}  // namespace

std::int64_t BytesOfModel(const storage::ModelRecord& record) {
  // A loaded frame of 34 markers, 204 values, was measured with 1.16 kB (docs/capacity.md). The
  // Gaussians of the nodes, two doubles a value, count apart: a model can have small nodes.
  constexpr std::int64_t kValueOfFrame = 6;
  constexpr std::int64_t kValueOfNode = 16;
  const auto& nodes = record.nodes_per_layer;
  const std::int64_t node_count = std::accumulate(nodes.begin(), nodes.end(), std::int64_t{0});
  return record.dimension_count *
         (kValueOfFrame * std::int64_t{record.frame_count} + kValueOfNode * node_count);
}

ServedModel Unloaded(storage::ModelRecord record) {
  return {nullptr, 0, std::make_shared<const storage::ModelRecord>(std::move(record))};
}

bool ModelLifecycle::loads_on_demand() const { return services_.options.model_memory_bytes > 0; }

void ModelLifecycle::LoadStored() {
  const std::string& name = database_.name();
  auto newest = services_.store.ListModels(name, 0, 1);
  if (!newest.ok()) return ReportUnreadable(newest.status());
  const bool has_model = !newest->empty() && newest->front().current;
  if (!has_model || loads_on_demand()) {
    stored_version_ = has_model ? newest->front().version : 0;
    return Serve(has_model ? Unloaded(std::move(newest->front())) : ServedModel());
  }
  auto stored = ReadNewer({}, std::move(newest->front()));
  if (stored.ok()) return Serve(*std::move(stored));
  ReportUnreadable(stored.status());
  // The first look at a shared store tries again.
  if (!absl::IsDataLoss(stored.status())) stored_version_ = -1;
}

void ModelLifecycle::ReportUnreadable(const absl::Status& status) {
  const std::string& name = database_.name();
  spdlog::error("database '{}': cannot read the stored model: {}", name, status.ToString());
  if (!absl::IsDataLoss(status)) return;
  services_.corruptions.Note({fmt::format("databases/{}/models/{}", name, stored_version_.load()),
                              std::string(status.message())});
}

absl::StatusOr<ServedModel> ModelLifecycle::Use() {
  const MutexLock lock(mutex_);
  const auto now = services_.executor.Now();
  last_use_ = now;
  if (served_.unloaded == nullptr) return served_;
  if (!load_error_.ok() && now < load_error_time_ + kErrorTime) return load_error_;
  is_used_ = true;
  if (!is_updating_) ScheduleUpdate();  // else at its end, unless it has loaded the model
  return AwaitsChange();
}

std::int64_t ModelLifecycle::model_bytes() const {
  const SnapshotPointer model = snapshot();
  return model == nullptr ? 0 : BytesOfModel(model->record);
}

Executor::Clock::time_point ModelLifecycle::last_use() const {
  const MutexLock lock(mutex_);
  return last_use_;
}

bool ModelLifecycle::IsUpdating() const {
  const MutexLock lock(mutex_);
  return is_updating_ || update_pending_;
}

bool ModelLifecycle::Evict() {
  if (database_.open_streams() > 0) return false;  // its memory would not be freed
  {
    const MutexLock lock(mutex_);
    if (running_ != nullptr || is_updating_ || update_pending_ || is_closed_) return false;
  }
  bool is_evicted = false;
  const auto unloaded = [&](ServedModel served) -> absl::StatusOr<ServedModel> {
    if (served.snapshot == nullptr || !served.snapshot->is_stored()) return served;
    {
      const MutexLock lock(mutex_);
      if (running_ != nullptr) return served;  // a build has begun meanwhile, and uses it
    }
    is_evicted = true;
    spdlog::info("database '{}': model {} evicted from memory", database_.name(),
                 served.snapshot->record.version);
    return Unloaded(served.snapshot->record);
  };
  Replace(unloaded).IgnoreError();  // a deleted database has no model
  return is_evicted;
}

absl::StatusOr<ServedModel> ModelLifecycle::Loaded(ServedModel served) {
  const bool is_unloaded = served.unloaded != nullptr;
  auto loaded = Followed(std::move(served), /*is_needed=*/true);
  if (!is_unloaded || !absl::IsDataLoss(loaded.status())) return loaded;
  ReportUnreadable(loaded.status());
  return ServedModel();  // a build replaces it
}

void ModelLifecycle::SetLoadError(const absl::Status& error) {
  {
    const MutexLock lock(mutex_);
    load_error_ = error;
    load_error_time_ = services_.executor.Now();
    is_used_ = false;  // callers that wait get the error
  }
  database_.signal()->Notify();
}

absl::StatusOr<bool> ModelLifecycle::RebuildIfOutdated() {
  if (!operation().empty() || !services_.store.maintenance().CheckIsWritable().ok()) return false;
  MOTIONDB_ASSIGN_OR_RETURN(const bool is_up_to_date, IsUpToDate());
  if (is_up_to_date) return false;
  spdlog::info("database '{}': model is out of date with the stored clips; rebuilding",
               database_.name());
  MOTIONDB_RETURN_IF_ERROR(
      database_.WithSharedUse(DeletionPolicy::kAwait, [&] { return Request().status(); }));
  return true;
}

}  // namespace motiondb::server
