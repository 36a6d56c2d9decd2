// Listening at an address that an operator gave. Functions keep no state.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <string>

#include "absl/status/status.h"

namespace motiondb::server {

// Has the acceptor, which is not open, listen at HOST:PORT, port 0 for a free one. INVALID_ARGUMENT
// (no HOST:PORT, or nobody knows the host), UNAVAILABLE (cannot be listened on), both saying why.
absl::Status ListenOn(const std::string& listen, boost::asio::ip::tcp::acceptor& acceptor);

// The same for a moment alone, to know whether it can be done. Not for gRPC's own forms of an
// address, which are INVALID_ARGUMENT here.
absl::Status TryListening(const std::string& listen);

// Why an address cannot be listened on, found by trying. For those who are not told, as by gRPC.
// UNAVAILABLE, also where trying it finds nothing wrong.
absl::Status WhyNotListening(const std::string& listen);

}  // namespace motiondb::server
