// GetServerStatus of a server under test.
#pragma once

#include <catch2/catch.hpp>

#include "motiondb/v1/server.grpc.pb.h"
#include "tests/support/test_server.h"

namespace motiondb::tests {

inline v1::GetServerStatusResponse StatusOf(TestServer& server) {
  const auto stub = server.NewStub<v1::ServerService>();
  const auto answer =
      Ask(*stub, &v1::ServerService::Stub::GetServerStatus, v1::GetServerStatusRequest());
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  return answer.response;
}

}  // namespace motiondb::tests
