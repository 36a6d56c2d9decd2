// Clients that ping often are not disconnected.
#include <grpcpp/create_channel.h>

#include <catch2/catch.hpp>
#include <chrono>

#include "motiondb/v1/database.grpc.pb.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::keepalive_test {
namespace {

TEST_CASE("Keepalive: a client that pings often stays connected, with and without a call",
          "[security][rpc]") {
  TestServer server;
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  // The client then pings every second; ordinary clients every 10 to 20 s.
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 400);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  const auto channel = grpc::CreateCustomChannel(server.server().address(),
                                                 grpc::InsecureChannelCredentials(), arguments);
  const auto stub = v1::DatabaseService::NewStub(channel);
  const v1::ListDatabasesRequest request;
  REQUIRE(Ask(*stub, &v1::DatabaseService::Stub::ListDatabases, request).status.ok());
  // The default limits of gRPC would end the connection at the third ping. An idle channel reads
  // the reply to a ping, and pings again, only every 5 s; this wait makes it read at once.
  REQUIRE(channel->GetState(false) == GRPC_CHANNEL_READY);
  CHECK_FALSE(channel->WaitForStateChange(
      GRPC_CHANNEL_READY, std::chrono::system_clock::now() + std::chrono::seconds(5)));
  CHECK(Ask(*stub, &v1::DatabaseService::Stub::ListDatabases, request).status.ok());
}

}  // namespace
}  // namespace motiondb::tests::keepalive_test
