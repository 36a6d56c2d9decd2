// Clients that ping often are not disconnected.
#include <grpcpp/create_channel.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "motiondb/v1/database.grpc.pb.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::keepalive_test {
namespace {

TEST_CASE("Keepalive: a client that pings often stays connected, with and without a call",
          "[security][rpc]") {
  TestServer server;
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 1500);  // ordinary clients: 10 to 20 s
  arguments.SetInt(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  const auto channel = grpc::CreateCustomChannel(server.server().address(),
                                                 grpc::InsecureChannelCredentials(), arguments);
  const auto stub = v1::DatabaseService::NewStub(channel);
  const v1::ListDatabasesRequest request;
  REQUIRE(Ask(*stub, &v1::DatabaseService::Stub::ListDatabases, request).status.ok());
  // gRPC's own limits would end the connection at the third ping.
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(7);
  while (std::chrono::steady_clock::now() < end) {
    REQUIRE(channel->GetState(false) == GRPC_CHANNEL_READY);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  CHECK(Ask(*stub, &v1::DatabaseService::Stub::ListDatabases, request).status.ok());
}

}  // namespace
}  // namespace motiondb::tests::keepalive_test
