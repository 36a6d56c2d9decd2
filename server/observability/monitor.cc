#include "server/observability/monitor.h"

#include <fmt/format.h>
#include <prometheus/text_serializer.h>
#include <spdlog/spdlog.h>
#include <sys/statvfs.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <utility>

#include "server/engine/engine.h"
#include "server/engine/snapshot.h"
#include "server/engine/work/clock.h"
#include "server/observability/log.h"
#include "server/observability/server_statistics.h"
#include "storage/thread_scopes.h"

namespace motiondb::server {

namespace {

std::int64_t FileBytes(const std::string& path) {
  std::error_code error;
  const auto bytes = std::filesystem::file_size(path, error);
  return error ? 0 : static_cast<std::int64_t>(bytes);
}

// Free bytes exclude blocks reserved for the superuser.
void SetDisk(const std::string& path, ServerStatistics& statistics) {
  struct statvfs disk {};
  if (statvfs(path.c_str(), &disk) != 0) return;
  statistics.disk_bytes = static_cast<std::int64_t>(disk.f_blocks * disk.f_frsize);
  statistics.disk_free_bytes = static_cast<std::int64_t>(disk.f_bavail * disk.f_frsize);
}

DatabaseStatistics StatisticsOf(Engine& engine, const LiveDatabase& database) {
  DatabaseStatistics statistics{.name = database.name(),
                                .stored = database.stored(),
                                .operation = engine.CurrentOperation(database),
                                .rebuilds = database.lifecycle().rebuilds(),
                                .leases = database.lifecycle().leases(),
                                .open_streams = database.open_streams(),
                                .windows = database.recognized_windows()};
  statistics.model_bytes = database.lifecycle().model_bytes();
  const ServedModel served = database.lifecycle().served();
  if (served.record() != nullptr) {
    statistics.model = *served.record();
    if (served.snapshot != nullptr) {
      statistics.missing_revisions =
          std::max<std::int64_t>(0, database.seen_revision() - served.revision);
    }
    const std::int64_t age_us = NowMicroseconds() - statistics.model->create_time_us;
    statistics.model_age_seconds = std::max(0.0, static_cast<double>(age_us) * 1e-6);
  }
  return statistics;
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
  const storage::MutexLock lock(monitor_.engine_mutex_);
  monitor_.engine_ = &engine;
}

Monitor::Attachment::~Attachment() {
  const storage::MutexLock lock(monitor_.engine_mutex_);
  monitor_.engine_ = nullptr;
}

ServerStatistics Monitor::CollectStatistics() const {
  ServerStatistics statistics{.phase = phase_,
                              .version = MOTIONDB_VERSION,
                              .start_time_us = start_time_us_,
                              .encrypted = encrypted_,
                              .authenticated = authenticated_,
                              .certificate_expiry_s = certificate_end_time_s_,
                              .ended_calls = calls_.ended(),
                              .failed_calls = calls_.failed(),
                              .methods = calls_.Methods(),
                              .authentication_failures = calls_.authentication_failures(),
                              .open_connections = connections_.open,
                              .refused_connections = connections_.refused,
                              .ended_connections = connections_.ended,
                              .open_calls = calls_.open(),
                              .open_streams = calls_.open_streams(),
                              .process = ReadProcessStatistics()};
  if (!options_.store_path.empty()) {
    statistics.store_bytes = FileBytes(options_.store_path);
    statistics.log_bytes = FileBytes(options_.store_path + "-wal");
    SetDisk(options_.store_path, statistics);
  }
  const storage::ReadLock lock(engine_mutex_);
  if (engine_ == nullptr) return statistics;
  statistics.queued = engine_->workers().queued();
  statistics.request_threads = engine_->workers().request_threads();
  statistics.running_heavy_calls = engine_->workers().running_heavy();
  statistics.write_failures = engine_->store().write_failures();
  statistics.store_connections = engine_->store().connections();
  statistics.look_age_seconds = engine_->SecondsSinceLook();
  statistics.corruptions = engine_->corruptions();
  for (const auto& database : engine_->Databases()) {
    statistics.databases.push_back(StatisticsOf(*engine_, *database));
  }
  return statistics;
}

Readiness Monitor::CheckReadiness() const {
  const Phase phase = phase_;
  if (phase == Phase::kDraining) return {false, "draining: the server is about to stop"};
  const storage::ReadLock lock(engine_mutex_);
  if (phase == Phase::kStarting || engine_ == nullptr) {
    return {false, "starting: models are being read"};
  }
  storage::MotionStore& store = engine_->store();
  // PostgreSQL can hang; the thread also answers /metrics.
  const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(3);
  const core::Cancelled cancelled = [&] { return std::chrono::steady_clock::now() > latest; };
  const storage::ReadScope scope(cancelled);
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
  for (auto& family : FamiliesOf(CollectStatistics())) families.push_back(std::move(family));
  return prometheus::TextSerializer().Serialize(families);
}

CallWatch::CallWatch(Monitor& monitor, std::string_view method, CallKind kind)
    : monitor_(monitor), method_(monitor.calls().Find(method)), kind_(kind) {
  monitor_.calls().Begin(kind_);
}

CallWatch::~CallWatch() {
  if (!ended_) Count(absl::StatusCode::kCancelled);
}

void CallWatch::End(absl::StatusCode code, const std::string& message,
                    const std::string& request_id, const std::string& peer) {
  const double seconds = Count(code);
  LogCall({.method = method_.name(),
           .request_id = request_id,
           .peer = peer,
           .kind = kind_,
           .code = code,
           .message = message,
           .seconds = seconds},
          monitor_.slow_call());
}

double CallWatch::Count(absl::StatusCode code) {
  ended_ = true;
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began_;
  monitor_.calls().End(method_, kind_, code, took.count());
  return took.count();
}

namespace {

spdlog::level::level_enum LevelOf(const EndedCall& call, std::chrono::duration<double> slow) {
  if (IsServerFault(call.code)) return spdlog::level::err;
  const bool is_slow =
      call.kind == CallKind::kWork && slow.count() > 0 && call.seconds >= slow.count();
  return is_slow ? spdlog::level::warn : spdlog::level::debug;
}

}  // namespace

void LogCall(const EndedCall& call, std::chrono::duration<double> slow) {
  const auto level = LevelOf(call, slow);
  if (!spdlog::should_log(level)) return;
  const LogFields fields{{"request_id", call.request_id},
                         {"method", call.method},
                         {"code", std::string(CodeName(call.code))},
                         {"milliseconds", std::round(call.seconds * 1e6) / 1e3},
                         {"peer", call.peer}};
  const char* const event = level == spdlog::level::err    ? "call failed"
                            : level == spdlog::level::warn ? "slow call"
                                                           : "call";
  if (call.message.empty()) {
    spdlog::log(level, "{}", event);
  } else {
    spdlog::log(level, "{}: {}", event, call.message);
  }
}

}  // namespace motiondb::server
