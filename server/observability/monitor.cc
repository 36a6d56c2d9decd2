#include "server/observability/monitor.h"

#include <fmt/format.h>
#include <prometheus/text_serializer.h>
#include <sys/statvfs.h>

#include <filesystem>
#include <mutex>
#include <utility>

#include "server/engine/clock.h"
#include "server/engine/engine.h"
#include "server/engine/snapshot.h"
#include "server/observability/metric_families.h"

namespace motiondb::server {
namespace {

std::int64_t FileBytes(const std::string& path) {
  std::error_code error;
  const auto bytes = std::filesystem::file_size(path, error);
  return error ? 0 : static_cast<std::int64_t>(bytes);
}

// What is kept for the superuser is not counted as free.
void SetDisk(const std::string& path, ServerFigures& figures) {
  struct statvfs disk {};
  if (statvfs(path.c_str(), &disk) != 0) return;
  figures.disk_bytes = static_cast<std::int64_t>(disk.f_blocks * disk.f_frsize);
  figures.disk_free_bytes = static_cast<std::int64_t>(disk.f_bavail * disk.f_frsize);
}

DatabaseFigures FiguresOf(Engine& engine, const LiveDatabase& database) {
  DatabaseFigures figures{.name = database.name(),
                          .stored = database.stored(),
                          .operation = engine.CurrentOperation(database),
                          .rebuilds = database.rebuilds(),
                          .open_streams = database.open_streams()};
  if (const auto snapshot = database.snapshot()) {
    figures.model = snapshot->record;
    const std::int64_t age_us = NowMicroseconds() - snapshot->record.create_time_us;
    figures.model_age_seconds = std::max(0.0, static_cast<double>(age_us) * 1e-6);
  }
  return figures;
}

}  // namespace

Monitor::Monitor(MonitorOptions options)
    : options_(std::move(options)),
      start_time_us_(NowMicroseconds()),
      calls_(registry_, options_.methods) {}

void Monitor::SetTransport(bool encrypted, bool authenticated) {
  encrypted_ = encrypted;
  authenticated_ = authenticated;
}

Monitor::Attachment::Attachment(Monitor& monitor, Engine& engine) : monitor_(monitor) {
  const std::unique_lock lock(monitor_.engine_mutex_);
  monitor_.engine_ = &engine;
}

Monitor::Attachment::~Attachment() {
  const std::unique_lock lock(monitor_.engine_mutex_);
  monitor_.engine_ = nullptr;
}

ServerFigures Monitor::Figures() const {
  ServerFigures figures{.phase = phase_,
                        .version = MOTIONDB_VERSION,
                        .start_time_us = start_time_us_,
                        .encrypted = encrypted_,
                        .authenticated = authenticated_,
                        .certificate_end_time_s = certificate_end_time_s_,
                        .ended_calls = calls_.ended(),
                        .failed_calls = calls_.failed(),
                        .methods = calls_.Methods(),
                        .authentication_failures = calls_.authentication_failures(),
                        .open_connections = connections_.open,
                        .refused_connections = connections_.refused,
                        .ended_connections = connections_.ended,
                        .open_calls = calls_.open(),
                        .open_streams = calls_.open_streams(),
                        .process = ReadProcessFigures()};
  if (!options_.store_path.empty()) {
    figures.store_bytes = FileBytes(options_.store_path);
    figures.log_bytes = FileBytes(options_.store_path + "-wal");
    SetDisk(options_.store_path, figures);
  }
  const std::shared_lock lock(engine_mutex_);
  if (engine_ == nullptr) return figures;
  figures.queued = engine_->workers().queued();
  figures.request_threads = engine_->workers().request_threads();
  figures.running_heavy_calls = engine_->workers().running_heavy();
  figures.write_failures = engine_->store().write_failures();
  figures.damages = engine_->damages();
  for (const auto& database : engine_->Databases()) {
    figures.databases.push_back(FiguresOf(*engine_, *database));
  }
  return figures;
}

Readiness Monitor::CheckReadiness() const {
  const Phase phase = phase_;
  if (phase == Phase::kDraining) return {false, "draining: the server is about to stop"};
  const std::shared_lock lock(engine_mutex_);
  if (phase == Phase::kStarting || engine_ == nullptr) {
    return {false, "starting: models are being read"};
  }
  storage::MotionStore& store = engine_->store();
  const auto read = store.ListDatabases({.limit = 1});
  if (!read.ok()) {
    return {false,
            fmt::format("the store cannot be read: {}", std::string(read.status().message()))};
  }
  if (const absl::Status writes = store.CheckWrites(); !writes.ok()) {
    return {false, fmt::format("queries are answered, but nothing is stored: {}",
                               std::string(writes.message()))};
  }
  return {true, "ready"};
}

std::string Monitor::Exposition() const {
  std::vector<prometheus::MetricFamily> families = registry_.Collect();
  for (auto& family : FamiliesOf(Figures())) families.push_back(std::move(family));
  return prometheus::TextSerializer().Serialize(families);
}

}  // namespace motiondb::server
