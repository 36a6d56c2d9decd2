// Statistics of the server at one moment, and their conversion to Prometheus metrics.
#pragma once

#include <prometheus/metric_family.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/engine/live_database.h"
#include "server/engine/model_lifecycle.h"
#include "server/engine/work/workers.h"
#include "server/observability/call_meter.h"
#include "storage/motion_store.h"
#include "storage/records.h"
#include "storage/store_maintenance.h"

namespace motiondb::server {

// Statistics of this process from the operating system.
struct ProcessStatistics {
  std::int64_t resident_bytes = 0;
  std::int64_t virtual_bytes = 0;
  double cpu_seconds = 0;  // user and system time of all threads since the start
  int thread_count = 0;
  int open_descriptors = 0;
  std::int64_t max_descriptors = 0;
};

// Reads /proc/self and getrusage; a value that cannot be read is 0.
ProcessStatistics ReadProcessStatistics();

enum class Phase {
  kStarting,  // models are being read
  kServing,
  kDraining,  // calls in flight may end, new calls are refused
};

struct DatabaseStatistics {
  std::string name;
  StoredAmount stored;
  std::optional<storage::ModelRecord> model;
  double model_age_seconds = 0;
  std::int64_t model_bytes = 0;  // memory of the model, estimated; 0: not in memory
  std::optional<storage::OperationRecord> operation;  // pending or running build
  RebuildTally rebuilds;
  LeaseTally leases;
  std::int64_t missing_revisions = 0;  // of a shared store, in the model; at the last look
  int open_streams = 0;
  WindowTally windows;
};

// Source of the metrics, GetServerStatus and readiness.
struct ServerStatistics {
  Phase phase = Phase::kStarting;
  std::string version;
  std::int64_t start_time_us = 0;
  bool encrypted = false;
  bool authenticated = false;
  std::int64_t certificate_expiry_s = 0;  // Unix time; 0: no TLS
  std::int64_t ended_calls = 0;
  std::int64_t failed_calls = 0;          // by the server's fault
  std::vector<MethodStatistics> methods;  // with ended calls, in order of name
  std::int64_t authentication_failures = 0;
  int open_connections = 0;
  std::int64_t refused_connections = 0;  // see ConnectionMeter
  std::int64_t ended_connections = 0;
  int open_calls = 0;
  int open_streams = 0;
  QueueLengths queued;
  int request_threads = 0;
  int running_heavy_calls = 0;
  storage::WriteFailures write_failures;
  storage::ConnectionStatistics store_connections;
  double look_age_seconds = 0;  // see Engine::SecondsSinceLook
  ProcessStatistics process;
  std::int64_t store_bytes = 0;
  std::int64_t log_bytes = 0;
  std::int64_t disk_bytes = 0;                // size of the store's file system; 0: unknown
  std::int64_t disk_free_bytes = 0;           // available to the server
  std::vector<DatabaseStatistics> databases;  // in order of name; none before the models are read
  std::vector<storage::Corruption> corruptions;  // found since the start, at most 100
};

// Converts the statistics to Prometheus metrics (docs/metrics.md). A deleted database has no
// series.
std::vector<prometheus::MetricFamily> FamiliesOf(const ServerStatistics& statistics);

}  // namespace motiondb::server
