#include "server/observability/server_statistics.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <utility>

#include "server/observability/metric_families.h"
#include "server/observability/store_metrics.h"

namespace motiondb::server {

namespace {

using prometheus::MetricType;

// Uses the names of Prometheus' client libraries, for common dashboards.
void AddProcess(const ServerStatistics& figures, MetricFamilies& families) {
  const ProcessStatistics& process = figures.process;
  families.Add(MetricType::Counter, "process_cpu_seconds_total",
               "User and system time of the process, in seconds.", process.cpu_seconds);
  families.Add(MetricType::Gauge, "process_resident_memory_bytes",
               "Memory of the process that is in RAM.",
               static_cast<double>(process.resident_bytes));
  families.Add(MetricType::Gauge, "process_virtual_memory_bytes", "Address space of the process.",
               static_cast<double>(process.virtual_bytes));
  families.Add(MetricType::Gauge, "process_threads", "Threads of the process.",
               process.thread_count);
  families.Add(MetricType::Gauge, "process_open_fds", "Open file descriptors.",
               process.open_descriptors);
  families.Add(MetricType::Gauge, "process_max_fds", "Maximum of open file descriptors.",
               static_cast<double>(process.max_descriptors));
  families.Add(MetricType::Gauge, "process_start_time_seconds",
               "Start time of the process, in seconds since the Unix epoch.",
               static_cast<double>(figures.start_time_us) * 1e-6);
}

void AddServer(const ServerStatistics& figures, MetricFamilies& families) {
  families.Add(MetricType::Gauge, "motiondb_build_info", "Always 1; the version is its label.", 1,
               {{"version", figures.version}});
  families.Add(MetricType::Gauge, "motiondb_serving",
               "1 while the server accepts calls; 0 while it starts or drains.",
               figures.phase == Phase::kServing ? 1 : 0);
  families.Add(MetricType::Gauge, "motiondb_open_connections", "Connections of clients.",
               figures.open_connections);
  families.Add(MetricType::Counter, "motiondb_refused_connections_total",
               "Connections refused: no free descriptor, or too many of one address.",
               static_cast<double>(figures.refused_connections));
  families.Add(MetricType::Counter, "motiondb_ended_connections_total",
               "Connections that the server closed: client error, or out of memory.",
               static_cast<double>(figures.ended_connections));
  families.Add(MetricType::Gauge, "motiondb_open_requests", "Calls in flight, with streams.",
               figures.open_calls);
  families.Add(MetricType::Gauge, "motiondb_open_streams", "Streams of frames in flight.",
               figures.open_streams);
  families.Begin(MetricType::Gauge, "motiondb_queue_length",
                 "Work that waits for a thread, by pool.");
  families.Put({{"queue", "requests"}}, figures.queued.requests);
  families.Put({{"queue", "heavy_requests"}}, figures.queued.heavy_requests);
  families.Put({{"queue", "changes"}}, figures.queued.changes);
  families.Put({{"queue", "urgent_changes"}}, figures.queued.urgent_changes);
  families.Put({{"queue", "maintenance"}}, figures.queued.maintenance);
  families.Add(MetricType::Gauge, "motiondb_request_threads", "Threads that process requests.",
               figures.request_threads);
  families.Add(MetricType::Gauge, "motiondb_running_heavy_calls",
               "Heavy calls that have a thread or are next for one.", figures.running_heavy_calls);
  families.Add(MetricType::Gauge, "motiondb_store_bytes", "Size of the store's file.",
               static_cast<double>(figures.store_bytes));
  families.Add(MetricType::Gauge, "motiondb_log_bytes", "Size of the store's write-ahead log.",
               static_cast<double>(figures.log_bytes));
  families.Add(MetricType::Gauge, "motiondb_damages",
               "Corrupt items found since the start, at most 100.",
               static_cast<double>(figures.corruptions.size()));
  families.Add(
      MetricType::Gauge, "motiondb_certificate_end_time_seconds",
      "Expiry of the first certificate that expires, of the server's chain or the client CA, in "
      "seconds since the Unix epoch; 0 without TLS.",
      static_cast<double>(figures.certificate_expiry_s));
}

using Value = std::function<double(const DatabaseStatistics&)>;

// Adds a gauge with a series for each database.
void AddEach(const ServerStatistics& figures, const char* name, const char* help,
             const Value& value, MetricFamilies& families) {
  families.Begin(MetricType::Gauge, name, help);
  for (const DatabaseStatistics& database : figures.databases) {
    families.Put({{"database", database.name}}, value(database));
  }
}

// Adds a gauge with a series for each database that has a model.
void AddEachModel(const ServerStatistics& figures, const char* name, const char* help,
                  const Value& value, MetricFamilies& families) {
  families.Begin(MetricType::Gauge, name, help);
  for (const DatabaseStatistics& database : figures.databases) {
    if (database.model) families.Put({{"database", database.name}}, value(database));
  }
}

void AddDatabases(const ServerStatistics& figures, MetricFamilies& families) {
  families.Add(MetricType::Gauge, "motiondb_databases", "Databases.",
               static_cast<double>(figures.databases.size()));
  AddEach(
      figures, "motiondb_database_clips", "Stored clips.",
      [](const auto& database) { return database.stored.clip_count; }, families);
  AddEach(
      figures, "motiondb_database_frames",
      "Frames of the stored clips, at the database's frame rate.",
      [](const auto& database) { return static_cast<double>(database.stored.frame_count); },
      families);
  AddEach(
      figures, "motiondb_database_bytes", "Size of the stored clips.",
      [](const auto& database) { return static_cast<double>(database.stored.byte_count); },
      families);
  AddEach(
      figures, "motiondb_database_streams", "Streams in flight that use the model.",
      [](const auto& database) { return database.open_streams; }, families);
  AddEach(
      figures, "motiondb_model_version", "Version of the current model; 0 without one.",
      [](const auto& database) { return database.model ? database.model->version : 0; }, families);
  AddEach(
      figures, "motiondb_model_memory_bytes",
      "Memory of the model, estimated from its size; 0 if it is not in memory.",
      [](const auto& database) { return static_cast<double>(database.model_bytes); }, families);
  AddEachModel(
      figures, "motiondb_model_age_seconds", "Age of the current model.",
      [](const auto& database) { return database.model_age_seconds; }, families);
  AddEachModel(
      figures, "motiondb_model_frames", "Frames in the current model.",
      [](const auto& database) { return database.model->frame_count; }, families);
  AddEachModel(
      figures, "motiondb_model_build_seconds", "Duration of the build of the current model.",
      [](const auto& database) { return database.model->build_seconds; }, families);
}

void AddWindows(const ServerStatistics& figures, MetricFamilies& families) {
  families.Begin(MetricType::Counter, "motiondb_recognized_windows_total",
                 "Windows that Recognize and Observe answered since the start, by answer.");
  for (const DatabaseStatistics& database : figures.databases) {
    const auto put = [&](const char* answer, std::int64_t count) {
      families.Put({{"database", database.name}, {"answer", answer}}, static_cast<double>(count));
    };
    put("known", database.windows.known);
    put("unknown", database.windows.unknown);
    put("uncalibrated", database.windows.uncalibrated);
  }
}

void AddRebuilds(const ServerStatistics& figures, MetricFamilies& families) {
  AddEach(
      figures, "motiondb_rebuild_pending", "1 while a build of the model waits or runs, else 0.",
      [](const auto& database) { return database.operation ? 1 : 0; }, families);
  AddEach(
      figures, "motiondb_rebuild_progress",
      "Progress of the build that waits or runs, 0 to 1; 1 if there is none.",
      [](const auto& database) { return database.operation ? database.operation->progress : 1; },
      families);
  families.Begin(MetricType::Counter, "motiondb_rebuilds_total",
                 "Ended builds since the start, by outcome.");
  for (const DatabaseStatistics& database : figures.databases) {
    const auto put = [&](const char* outcome, std::int64_t count) {
      families.Put({{"database", database.name}, {"outcome", outcome}}, static_cast<double>(count));
    };
    put("succeeded", database.rebuilds.succeeded);
    put("failed", database.rebuilds.failed);
    put("cancelled", database.rebuilds.cancelled);
  }
  families.Begin(MetricType::Summary, "motiondb_rebuild_seconds",
                 "Duration of builds, of any outcome.");
  for (const DatabaseStatistics& database : figures.databases) {
    const RebuildTally& rebuilds = database.rebuilds;
    families.PutSummary({{"database", database.name}},
                        rebuilds.succeeded + rebuilds.failed + rebuilds.cancelled,
                        rebuilds.seconds);
  }
}

}  // namespace

std::vector<prometheus::MetricFamily> FamiliesOf(const ServerStatistics& figures) {
  MetricFamilies families;
  AddServer(figures, families);
  AddStore(figures, families);
  AddDatabases(figures, families);
  AddWindows(figures, families);
  AddRebuilds(figures, families);
  AddProcess(figures, families);
  return std::move(families).Take();
}

namespace {

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
}

int CountEntries(const char* folder) {
  std::error_code error;
  int count = 0;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    ++count;
  }
  return count;
}

}  // namespace

ProcessStatistics ReadProcessStatistics() {
  ProcessStatistics figures;
  std::int64_t virtual_pages = 0, resident_pages = 0;
  if (std::ifstream("/proc/self/statm") >> virtual_pages >> resident_pages) {
    const std::int64_t page_bytes = sysconf(_SC_PAGESIZE);
    figures.virtual_bytes = virtual_pages * page_bytes;
    figures.resident_bytes = resident_pages * page_bytes;
  }
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) == 0) {
    figures.cpu_seconds = Seconds(usage.ru_utime) + Seconds(usage.ru_stime);
  }
  rlimit descriptors{};
  if (getrlimit(RLIMIT_NOFILE, &descriptors) == 0) {
    figures.max_descriptors = static_cast<std::int64_t>(descriptors.rlim_cur);
  }
  // Minus the descriptor that reads the folder.
  figures.open_descriptors = std::max(0, CountEntries("/proc/self/fd") - 1);
  figures.thread_count = CountEntries("/proc/self/task");
  return figures;
}

}  // namespace motiondb::server
