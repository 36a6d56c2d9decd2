// Listening at an address that an operator gave. Functions keep no state.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::server {

// Has the acceptor, which is not open, listen at HOST:PORT, port 0 for a free one. INVALID_ARGUMENT
// (no HOST:PORT, or nobody knows the host), NOT_FOUND (not an address of this machine), UNAVAILABLE
// (cannot be listened on), all saying why.
absl::Status ListenOn(const std::string& listen, boost::asio::ip::tcp::acceptor& acceptor);

// The same for a moment alone, to know whether it can be done.
absl::Status TryListening(const std::string& listen);

// The addresses of the host of HOST:PORT in numbers, "127.0.0.1" and "[::1]"; at least one.
// INVALID_ARGUMENT as above.
absl::StatusOr<std::vector<std::string>> AddressesOf(const std::string& listen);

}  // namespace motiondb::server
