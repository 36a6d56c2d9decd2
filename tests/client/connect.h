// Connects a client to a fake server.
#pragma once

#include <motiondb/client.h>

#include <catch2/catch.hpp>
#include <string>

namespace motiondb::tests {

inline client::Client ConnectTo(const std::string& address) {
  client::ClientOptions options;
  options.server = address;
  auto connected = client::Client::Connect(options);
  REQUIRE(connected.ok());
  return *std::move(connected);
}

}  // namespace motiondb::tests
