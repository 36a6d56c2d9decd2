// Calls on the whole store, whose duration depends on its size.
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdint>
#include <thread>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/database.pb.h"
#include "motiondb/v1/store.grpc.pb.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::upkeep_test {
namespace {

// Returns the size of a backup; negative if it failed. Without Catch's macros, because other
// threads call it.
std::int64_t BackedUpBytes(v1::StoreService::Stub& store) {
  grpc::ClientContext context;
  const auto reader = store.BackupStore(&context, {});
  v1::BackupStoreResponse response;
  std::int64_t bytes = 0;
  while (reader->Read(&response)) bytes += static_cast<std::int64_t>(response.block().size());
  return reader->Finish().ok() ? bytes : -1;
}

TEST_CASE("Maintenance: ingests and queries continue during a backup, with one request thread",
          "[server][rpc]") {
  server::ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.engine.rebuild_delay = std::chrono::milliseconds(50);
  options.engine.query_threads = 1;
  TestServer server(options);
  server.CreateTrained("db");
  const auto store = server.NewStub<v1::StoreService>();
  server.gate().Close();
  std::int64_t bytes = 0;
  std::thread backup([&] { bytes = BackedUpBytes(*store); });
  server.gate().AwaitArrival();
  server.IngestFigure("db", "late", "walk", {.phase = 0.4});
  CHECK(server.Describe("db").stored_clip_count() == 4);
  server.gate().Open();
  backup.join();
  CHECK(bytes > 0);
}

TEST_CASE("Maintenance: the server's time limit for calls does not apply", "[server][rpc]") {
  server::ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.calls.max_call_time = std::chrono::milliseconds(0);
  TestServer server(options);
  const auto store = server.NewStub<v1::StoreService>();
  CHECK(BackedUpBytes(*store) > 0);
  grpc::ClientContext context;
  const auto reader = store->VerifyStore(&context, {});
  v1::VerifyStoreResponse response;
  while (reader->Read(&response)) {
  }
  CHECK(reader->Finish().ok());
  CHECK(response.has_summary());
}

}  // namespace
}  // namespace motiondb::tests::upkeep_test
