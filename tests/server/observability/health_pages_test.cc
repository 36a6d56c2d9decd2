// HTTP pages while a server starts, serves and drains.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "server/observability/health_server.h"
#include "tests/server/observability/http_client.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests::health_pages_test {
namespace {

using Catch::Contains;
using Catch::EndsWith;
using Catch::StartsWith;
using server::Monitor;
using server::Phase;

TEST_CASE("HealthPages: alive from the start, ready when it serves", "[server][http]") {
  Monitor monitor({});
  const auto started = server::StartHealthServer("127.0.0.1:0", monitor);
  REQUIRE(started.ok());
  const std::string& address = (*started)->address();
  CHECK_THAT(Fetch(address, "/livez"), StartsWith("HTTP/1.1 200 ") && EndsWith("alive\n"));
  CHECK_THAT(Fetch(address, "/readyz"), StartsWith("HTTP/1.1 503 ") && Contains("starting"));
  {
    TestEngine engine;
    const Monitor::Attachment attachment(monitor, *engine);
    monitor.SetPhase(Phase::kServing);
    CHECK_THAT(Fetch(address, "/readyz"), StartsWith("HTTP/1.1 200 ") && EndsWith("ready\n"));
    monitor.SetPhase(Phase::kDraining);
    CHECK_THAT(Fetch(address, "/readyz"), StartsWith("HTTP/1.1 503 ") && Contains("draining"));
    CHECK_THAT(Fetch(address, "/livez"), StartsWith("HTTP/1.1 200 "));
  }
  CHECK_THAT(Fetch(address, "/"), Contains("/metrics"));
}

TEST_CASE("HealthPages: metrics have Prometheus' text format and the sizes of the store's files",
          "[server][http]") {
  TemporaryDirectory directory;
  const std::string store = directory / "store.db";
  std::ofstream(store) << std::string(1000, 'x');
  std::ofstream(store + "-wal") << std::string(300, 'x');
  Monitor monitor({.store_path = store});
  const auto started = server::StartHealthServer("127.0.0.1:0", monitor);
  REQUIRE(started.ok());
  CHECK_THAT(Fetch((*started)->address(), "/metrics"),
             Contains("content-type: text/plain; version=0.0.4; charset=utf-8\r\n") &&
                 Contains("motiondb_store_bytes 1000\n") && Contains("motiondb_log_bytes 300\n") &&
                 Contains("motiondb_damages 0\n") && Contains("motiondb_serving 0\n"));
}

TEST_CASE("HealthServer: no pages, and an address in use", "[server][http]") {
  Monitor monitor({});
  CHECK(*server::StartHealthServer("none", monitor) == nullptr);
  const auto started = server::StartHealthServer("127.0.0.1:0", monitor);
  REQUIRE(started.ok());
  CHECK(absl::IsUnavailable(server::StartHealthServer((*started)->address(), monitor).status()));
  // The default address in use does not prevent a start. Another program may use it now and then.
  const auto first = server::StartHealthServer("", monitor);
  const auto second = server::StartHealthServer("", monitor);
  REQUIRE(first.ok());
  REQUIRE(second.ok());
  CHECK((*first == nullptr || *second == nullptr));
}

}  // namespace
}  // namespace motiondb::tests::health_pages_test
