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

namespace motiondb::server {

namespace {

using prometheus::MetricType;

// Uses the names of Prometheus' client libraries, for common dashboards.
void AddProcess(const ServerStatistics& statistics, MetricFamilies& families) {
  const ProcessStatistics& process = statistics.process;
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
               static_cast<double>(statistics.start_time_us) * 1e-6);
}

void AddServer(const ServerStatistics& statistics, MetricFamilies& families) {
  families.Add(MetricType::Gauge, "motiondb_build_info", "Always 1; the version is its label.", 1,
               {{"version", statistics.version}});
  families.Add(MetricType::Gauge, "motiondb_serving",
               "1 while the server accepts calls; 0 while it starts or drains.",
               statistics.phase == Phase::kServing ? 1 : 0);
  families.Add(MetricType::Gauge, "motiondb_open_connections", "Connections of clients.",
               statistics.open_connections);
  families.Add(MetricType::Counter, "motiondb_refused_connections_total",
               "Connections refused: no free descriptor, or too many of one address.",
               static_cast<double>(statistics.refused_connections));
  families.Add(MetricType::Counter, "motiondb_ended_connections_total",
               "Connections that the server closed: client error, or out of memory.",
               static_cast<double>(statistics.ended_connections));
  families.Add(MetricType::Gauge, "motiondb_open_requests", "Calls in flight, with streams.",
               statistics.open_calls);
  families.Add(MetricType::Gauge, "motiondb_open_streams", "Streams of frames in flight.",
               statistics.open_streams);
  families.Begin(MetricType::Gauge, "motiondb_queue_length",
                 "Work that waits for a thread, by pool.");
  families.Put({{"queue", "requests"}}, statistics.queued.requests);
  families.Put({{"queue", "heavy_requests"}}, statistics.queued.heavy_requests);
  families.Put({{"queue", "changes"}}, statistics.queued.changes);
  families.Put({{"queue", "urgent_changes"}}, statistics.queued.urgent_changes);
  families.Put({{"queue", "maintenance"}}, statistics.queued.maintenance);
  families.Add(MetricType::Gauge, "motiondb_request_threads", "Threads that process requests.",
               statistics.request_threads);
  families.Add(MetricType::Gauge, "motiondb_running_heavy_calls",
               "Heavy calls that have a thread or are next for one.",
               statistics.running_heavy_calls);
  families.Add(MetricType::Gauge, "motiondb_store_bytes", "Size of the store's file.",
               static_cast<double>(statistics.store_bytes));
  families.Add(MetricType::Gauge, "motiondb_log_bytes", "Size of the store's write-ahead log.",
               static_cast<double>(statistics.log_bytes));
  families.Add(MetricType::Gauge, "motiondb_damages",
               "Corrupt items found since the start, at most 100.",
               static_cast<double>(statistics.corruptions.size()));
  families.Add(
      MetricType::Gauge, "motiondb_certificate_end_time_seconds",
      "Expiry of the first certificate that expires, of the server's chain or the client CA, in "
      "seconds since the Unix epoch; 0 without TLS.",
      static_cast<double>(statistics.certificate_expiry_s));
}

using Value = std::function<double(const DatabaseStatistics&)>;

// Adds a gauge with a series for each database.
void AddEach(const ServerStatistics& statistics, const char* name, const char* help,
             const Value& value, MetricFamilies& families) {
  families.Begin(MetricType::Gauge, name, help);
  for (const DatabaseStatistics& database : statistics.databases) {
    families.Put({{"database", database.name}}, value(database));
  }
}

// Adds a gauge with a series for each database that has a model.
void AddEachModel(const ServerStatistics& statistics, const char* name, const char* help,
                  const Value& value, MetricFamilies& families) {
  families.Begin(MetricType::Gauge, name, help);
  for (const DatabaseStatistics& database : statistics.databases) {
    if (database.model) families.Put({{"database", database.name}}, value(database));
  }
}

void AddDatabases(const ServerStatistics& statistics, MetricFamilies& families) {
  families.Add(MetricType::Gauge, "motiondb_databases", "Databases.",
               static_cast<double>(statistics.databases.size()));
  AddEach(
      statistics, "motiondb_database_clips", "Stored clips.",
      [](const auto& database) { return database.stored.clip_count; }, families);
  AddEach(
      statistics, "motiondb_database_frames",
      "Frames of the stored clips, at the database's frame rate.",
      [](const auto& database) { return static_cast<double>(database.stored.frame_count); },
      families);
  AddEach(
      statistics, "motiondb_database_bytes", "Size of the stored clips.",
      [](const auto& database) { return static_cast<double>(database.stored.byte_count); },
      families);
  AddEach(
      statistics, "motiondb_database_streams", "Streams in flight that use the model.",
      [](const auto& database) { return database.open_streams; }, families);
  AddEach(
      statistics, "motiondb_model_version", "Version of the current model; 0 without one.",
      [](const auto& database) { return database.model ? database.model->version : 0; }, families);
  AddEach(
      statistics, "motiondb_model_memory_bytes",
      "Memory of the model, estimated from its size; 0 if it is not in memory.",
      [](const auto& database) { return static_cast<double>(database.model_bytes); }, families);
  AddEachModel(
      statistics, "motiondb_model_age_seconds", "Age of the current model.",
      [](const auto& database) { return database.model_age_seconds; }, families);
  AddEachModel(
      statistics, "motiondb_model_frames", "Frames in the current model.",
      [](const auto& database) { return database.model->frame_count; }, families);
  AddEachModel(
      statistics, "motiondb_model_build_seconds", "Duration of the build of the current model.",
      [](const auto& database) { return database.model->build_seconds; }, families);
}

void AddWindows(const ServerStatistics& statistics, MetricFamilies& families) {
  families.Begin(MetricType::Counter, "motiondb_recognized_windows_total",
                 "Windows that Recognize and Observe answered since the start, by answer.");
  for (const DatabaseStatistics& database : statistics.databases) {
    const auto put = [&](const char* answer, std::int64_t count) {
      families.Put({{"database", database.name}, {"answer", answer}}, static_cast<double>(count));
    };
    put("known", database.windows.known);
    put("unknown", database.windows.unknown);
    put("uncalibrated", database.windows.uncalibrated);
  }
}

void AddRebuilds(const ServerStatistics& statistics, MetricFamilies& families) {
  AddEach(
      statistics, "motiondb_rebuild_pending", "1 while a build of the model waits or runs, else 0.",
      [](const auto& database) { return database.operation ? 1 : 0; }, families);
  AddEach(
      statistics, "motiondb_rebuild_progress",
      "Progress of the build that waits or runs, 0 to 1; 1 if there is none.",
      [](const auto& database) { return database.operation ? database.operation->progress : 1; },
      families);
  families.Begin(MetricType::Counter, "motiondb_rebuilds_total",
                 "Ended builds since the start, by outcome.");
  for (const DatabaseStatistics& database : statistics.databases) {
    const auto put = [&](const char* outcome, std::int64_t count) {
      families.Put({{"database", database.name}, {"outcome", outcome}}, static_cast<double>(count));
    };
    put("succeeded", database.rebuilds.succeeded);
    put("failed", database.rebuilds.failed);
    put("cancelled", database.rebuilds.cancelled);
  }
  families.Begin(MetricType::Summary, "motiondb_rebuild_seconds",
                 "Duration of builds, of any outcome.");
  for (const DatabaseStatistics& database : statistics.databases) {
    const RebuildTally& rebuilds = database.rebuilds;
    families.PutSummary({{"database", database.name}},
                        rebuilds.succeeded + rebuilds.failed + rebuilds.cancelled,
                        rebuilds.seconds);
  }
}

}  // namespace

std::vector<prometheus::MetricFamily> FamiliesOf(const ServerStatistics& statistics) {
  MetricFamilies families;
  AddServer(statistics, families);
  AddStore(statistics, families);
  AddDatabases(statistics, families);
  AddWindows(statistics, families);
  AddRebuilds(statistics, families);
  AddProcess(statistics, families);
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
  ProcessStatistics statistics;
  std::int64_t virtual_pages = 0, resident_pages = 0;
  if (std::ifstream("/proc/self/statm") >> virtual_pages >> resident_pages) {
    const std::int64_t page_bytes = sysconf(_SC_PAGESIZE);
    statistics.virtual_bytes = virtual_pages * page_bytes;
    statistics.resident_bytes = resident_pages * page_bytes;
  }
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) == 0) {
    statistics.cpu_seconds = Seconds(usage.ru_utime) + Seconds(usage.ru_stime);
  }
  rlimit descriptors{};
  if (getrlimit(RLIMIT_NOFILE, &descriptors) == 0) {
    statistics.max_descriptors = static_cast<std::int64_t>(descriptors.rlim_cur);
  }
  // Minus the descriptor that reads the folder.
  statistics.open_descriptors = std::max(0, CountEntries("/proc/self/fd") - 1);
  statistics.thread_count = CountEntries("/proc/self/task");
  return statistics;
}

}  // namespace motiondb::server
