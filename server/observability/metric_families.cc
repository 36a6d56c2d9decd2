#include "server/observability/metric_families.h"

#include "server/observability/server_statistics.h"

namespace motiondb::server {
namespace {

using prometheus::MetricType;

void AddWriteFailures(const ServerStatistics& statistics, MetricFamilies& families) {
  families.Begin(MetricType::Counter, "motiondb_store_failed_writes_total",
                 "Failed writes of the store since the start, by reason.");
  const auto put = [&](const char* reason, std::int64_t count) {
    families.Put({{"reason", reason}}, static_cast<double>(count));
  };
  put("no_space", statistics.write_failures.no_space);
  put("io_error", statistics.write_failures.io_error);
  put("corruption", statistics.write_failures.corruption);
  put("other", statistics.write_failures.other);
}

// No series until the store exists.
void AddDisk(const ServerStatistics& statistics, MetricFamilies& families) {
  const auto add = [&](const char* name, const char* help, std::int64_t bytes) {
    families.Begin(MetricType::Gauge, name, help);
    if (statistics.disk_bytes > 0) families.Put({}, static_cast<double>(bytes));
  };
  add("motiondb_disk_bytes", "Size of the file system that the store is on.",
      statistics.disk_bytes);
  add("motiondb_disk_free_bytes", "Free space of that file system for the server.",
      statistics.disk_free_bytes);
}

void AddConnections(const ServerStatistics& statistics, MetricFamilies& families) {
  const storage::ConnectionStatistics& store = statistics.store_connections;
  families.Begin(MetricType::Gauge, "motiondb_store_readers",
                 "Connections that read from the store, by state.");
  families.Put({{"state", "in_use"}}, store.leased_readers);
  families.Put({{"state", "idle"}}, store.open_readers - store.leased_readers);
  families.Add(MetricType::Gauge, "motiondb_store_max_readers",
               "Maximum of connections that read from the store.", store.max_readers);
  families.Add(MetricType::Gauge, "motiondb_store_waiting_reads",
               "Reads that wait for a connection.", store.waiting_reads);
  families.Begin(MetricType::Summary, "motiondb_store_read_wait_seconds",
                 "Time that reads have waited for a connection; reads that waited.");
  families.PutSummary({}, store.waited_reads, store.wait_seconds);
  families.Begin(MetricType::Counter, "motiondb_store_sessions_total",
                 "Attempts to open a session of PostgreSQL since the start, by outcome.");
  families.Put({{"outcome", "opened"}}, static_cast<double>(store.opened_sessions));
  families.Put({{"outcome", "failed"}}, static_cast<double>(store.failed_sessions));
}

void AddLag(const ServerStatistics& statistics, MetricFamilies& families) {
  families.Add(MetricType::Gauge, "motiondb_store_look_age_seconds",
               "Time since the last successful look at what other servers have changed; 0 with a "
               "store file.",
               statistics.look_age_seconds);
  families.Begin(MetricType::Gauge, "motiondb_model_missing_revisions",
                 "Revisions in a shared store that the model that answers queries lacks.");
  for (const DatabaseStatistics& database : statistics.databases) {
    if (database.model) {
      families.Put({{"database", database.name}}, static_cast<double>(database.missing_revisions));
    }
  }
}

void AddLeases(const ServerStatistics& statistics, MetricFamilies& families) {
  families.Begin(MetricType::Gauge, "motiondb_build_lease_held",
                 "1 while this server has the build lease of the database.");
  for (const DatabaseStatistics& database : statistics.databases) {
    families.Put({{"database", database.name}}, database.leases.is_held ? 1 : 0);
  }
  families.Begin(MetricType::Counter, "motiondb_build_leases_total",
                 "Build leases since the start, by outcome.");
  for (const DatabaseStatistics& database : statistics.databases) {
    const auto put = [&](const char* outcome, std::int64_t count) {
      families.Put({{"database", database.name}, {"outcome", outcome}}, static_cast<double>(count));
    };
    put("acquired", database.leases.acquired);
    put("refused", database.leases.refused);
    put("lost", database.leases.lost);
  }
}

}  // namespace

void AddStore(const ServerStatistics& statistics, MetricFamilies& families) {
  AddWriteFailures(statistics, families);
  AddDisk(statistics, families);
  AddConnections(statistics, families);
  AddLag(statistics, families);
  AddLeases(statistics, families);
}

}  // namespace motiondb::server
