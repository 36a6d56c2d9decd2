// What gRPC counts of its connections, for channelz, in all servers of the process. Safe to call
// from any thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace motiondb::server {

// Calls that came and were not answered with OK, or not yet.
std::int64_t CountUnansweredCalls();

struct ConnectionFigures {
  std::int64_t id = 0;
  std::string address;  // of the client: 4 or 16 bytes, as in a packet
  int port = 0;
  // Calls that gRPC keeps: those under way, and those that are over but not yet forgotten.
  std::int64_t kept_calls = 0;
};

// Asks for each, so it costs some 20 us a connection.
std::vector<ConnectionFigures> ListConnections();

}  // namespace motiondb::server
