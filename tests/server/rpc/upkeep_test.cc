// Calls on the store as a whole, which take as long as it is large.
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

// Of a backup; negative where it failed. Not for Catch's macros: called by other threads, too.
std::int64_t BackedUpBytes(v1::StoreService::Stub& store) {
  grpc::ClientContext context;
  const auto reader = store.BackupStore(&context, {});
  v1::BackupStoreResponse response;
  std::int64_t bytes = 0;
  while (reader->Read(&response)) bytes += static_cast<std::int64_t>(response.block().size());
  return reader->Finish().ok() ? bytes : -1;
}

TEST_CASE("Upkeep: clips come and queries go on while the store is copied, on one thread",
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

TEST_CASE("Upkeep: the server's own deadline is not for it", "[server][rpc]") {
  server::ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.calls.longest_call = std::chrono::milliseconds(0);
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
