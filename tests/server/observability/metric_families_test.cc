// Statistics in Prometheus' text format.
#include <prometheus/text_serializer.h>

#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "server/observability/server_statistics.h"

namespace motiondb::tests::metric_families_test {
namespace {

using Catch::Contains;
using server::DatabaseStatistics;
using server::ServerStatistics;

std::string Text(const ServerStatistics& figures) {
  return prometheus::TextSerializer().Serialize(server::FamiliesOf(figures));
}

TEST_CASE("MetricFamilies: a database without a model", "[server][metrics]") {
  ServerStatistics figures;
  figures.databases.push_back({.name = "walks", .stored = {7, 11969}});
  const std::string text = Text(figures);
  CHECK_THAT(text, Contains("motiondb_database_clips{database=\"walks\"} 7\n") &&
                       Contains("motiondb_database_frames{database=\"walks\"} 11969\n") &&
                       Contains("motiondb_model_version{database=\"walks\"} 0\n") &&
                       Contains("motiondb_rebuild_pending{database=\"walks\"} 0\n") &&
                       Contains("motiondb_rebuild_progress{database=\"walks\"} 1\n"));
  CHECK_THAT(text, !Contains("motiondb_model_age_seconds{"));
}

TEST_CASE("MetricFamilies: a model, its current and earlier builds", "[server][metrics]") {
  ServerStatistics figures;
  figures.databases.push_back({.name = "walks",
                               .model = storage::ModelRecord{.version = 3, .frame_count = 100},
                               .model_age_seconds = 12.5,
                               .operation = storage::OperationRecord{.progress = 0.25},
                               .rebuilds = {.succeeded = 2, .failed = 1, .seconds = 4.5}});
  CHECK_THAT(Text(figures),
             Contains("motiondb_model_version{database=\"walks\"} 3\n") &&
                 Contains("motiondb_model_frames{database=\"walks\"} 100\n") &&
                 Contains("motiondb_model_age_seconds{database=\"walks\"} 12.5\n") &&
                 Contains("motiondb_rebuild_pending{database=\"walks\"} 1\n") &&
                 Contains("motiondb_rebuild_progress{database=\"walks\"} 0.25\n") &&
                 Contains("motiondb_rebuilds_total{database=\"walks\",outcome=\"failed\"} 1\n") &&
                 Contains("motiondb_rebuild_seconds_count{database=\"walks\"} 3\n") &&
                 Contains("motiondb_rebuild_seconds_sum{database=\"walks\"} 4.5\n"));
}

TEST_CASE("MetricFamilies: the disk, when it is known", "[server][metrics]") {
  CHECK_THAT(Text({}), !Contains("motiondb_disk_free_bytes 0\n"));
  CHECK_THAT(
      Text({.disk_bytes = 1 << 30, .disk_free_bytes = 0}),
      Contains("motiondb_disk_bytes 1073741824\n") && Contains("motiondb_disk_free_bytes 0\n"));
}

TEST_CASE("MetricFamilies: failed writes by reason, and heavy calls", "[server][metrics]") {
  CHECK_THAT(Text({}), Contains("motiondb_store_failed_writes_total{reason=\"no_space\"} 0\n") &&
                           Contains("motiondb_running_heavy_calls 0\n"));
  const std::string text =
      Text({.open_connections = 3,
            .refused_connections = 5,
            .ended_connections = 7,
            .running_heavy_calls = 2,
            .write_failures = {.no_space = 4, .io_error = 3, .corruption = 2, .other = 1}});
  CHECK_THAT(text, Contains("motiondb_store_failed_writes_total{reason=\"no_space\"} 4\n") &&
                       Contains("motiondb_store_failed_writes_total{reason=\"io_error\"} 3\n") &&
                       Contains("motiondb_store_failed_writes_total{reason=\"corruption\"} 2\n") &&
                       Contains("motiondb_store_failed_writes_total{reason=\"other\"} 1\n") &&
                       Contains("motiondb_running_heavy_calls 2\n") &&
                       Contains("motiondb_open_connections 3\n") &&
                       Contains("motiondb_refused_connections_total 5\n") &&
                       Contains("motiondb_ended_connections_total 7\n"));
}

TEST_CASE("MetricFamilies: a store that several servers share", "[server][metrics]") {
  CHECK_THAT(Text({}), Contains("motiondb_store_look_age_seconds 0\n") &&
                           Contains("motiondb_store_sessions_total{outcome=\"failed\"} 0\n"));
  ServerStatistics figures;
  figures.look_age_seconds = 0.5;
  figures.store_connections = {.max_readers = 4,
                               .open_readers = 3,
                               .leased_readers = 2,
                               .waiting_reads = 7,
                               .waited_reads = 8,
                               .wait_seconds = 1.5,
                               .opened_sessions = 5,
                               .failed_sessions = 6};
  figures.databases.push_back({.name = "walks",
                               .model = storage::ModelRecord{.version = 3},
                               .leases = {true, 4, 3, 2},
                               .missing_revisions = 9});
  figures.databases.push_back({.name = "empty"});
  const std::string text = Text(figures);
  CHECK_THAT(text, Contains("motiondb_store_look_age_seconds 0.5\n") &&
                       Contains("motiondb_store_readers{state=\"in_use\"} 2\n") &&
                       Contains("motiondb_store_readers{state=\"idle\"} 1\n") &&
                       Contains("motiondb_store_max_readers 4\n") &&
                       Contains("motiondb_store_waiting_reads 7\n") &&
                       Contains("motiondb_store_read_wait_seconds_count 8\n") &&
                       Contains("motiondb_store_read_wait_seconds_sum 1.5\n") &&
                       Contains("motiondb_store_sessions_total{outcome=\"opened\"} 5\n") &&
                       Contains("motiondb_store_sessions_total{outcome=\"failed\"} 6\n"));
  const auto lease = [](const char* outcome) {
    return "motiondb_build_leases_total{database=\"walks\",outcome=\"" + std::string(outcome) +
           "\"} ";
  };
  CHECK_THAT(text, Contains("motiondb_build_lease_held{database=\"walks\"} 1\n") &&
                       Contains(lease("acquired") + "4\n") && Contains(lease("refused") + "3\n") &&
                       Contains(lease("lost") + "2\n"));
  CHECK_THAT(text, Contains("motiondb_model_missing_revisions{database=\"walks\"} 9\n") &&
                       !Contains("motiondb_model_missing_revisions{database=\"empty\"}"));
}

TEST_CASE("MetricFamilies: the expiry of the certificate, 0 without one", "[server][metrics]") {
  CHECK_THAT(Text({}), Contains("motiondb_certificate_end_time_seconds 0\n"));
  CHECK_THAT(Text({.certificate_expiry_s = 1'800'000'000}),
             Contains("motiondb_certificate_end_time_seconds 1800000000\n"));
}

TEST_CASE("MetricFamilies: names are valid for Prometheus and unique", "[server][metrics]") {
  std::set<std::string> names;
  for (const auto& family : server::FamiliesOf({})) {
    CAPTURE(family.name);
    CHECK(names.insert(family.name).second);
    CHECK((family.name.starts_with("motiondb_") || family.name.starts_with("process_")));
    CHECK(!family.help.empty());
    const bool counter = family.type == prometheus::MetricType::Counter;
    CHECK(counter == family.name.ends_with("_total"));
  }
}

}  // namespace
}  // namespace motiondb::tests::metric_families_test
