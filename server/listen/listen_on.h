// Listening at a configured address, HOST:PORT.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::server {

// Opens `acceptor` and listens at HOST:PORT; port 0 selects a free port. Errors:
// INVALID_ARGUMENT (malformed, or the host does not resolve), NOT_FOUND (not an address of this
// machine), UNAVAILABLE (in use, or not permitted).
absl::Status ListenOn(const std::string& listen, boost::asio::ip::tcp::acceptor& acceptor);

// Checks that ListenOn succeeds, and closes the socket again. Errors: those of ListenOn.
absl::Status CheckListening(const std::string& listen);

// Returns the numeric addresses of the host, such as "127.0.0.1" and "[::1]"; at least one.
// INVALID_ARGUMENT if the text is malformed or the host does not resolve.
absl::StatusOr<std::vector<std::string>> ResolveAddresses(const std::string& listen);

}  // namespace motiondb::server
