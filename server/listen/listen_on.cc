#include "server/listen/listen_on.h"

#include <boost/asio/io_context.hpp>
#include <cerrno>

#include "core/motion/error.h"

namespace motiondb::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

absl::StatusOr<tcp::resolver::results_type> Resolve(const std::string& listen) {
  const std::size_t colon = listen.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == listen.size()) {
    return core::InvalidArgument("expected HOST:PORT, got '{}'", listen);
  }
  std::string host = listen.substr(0, colon);
  if (host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  asio::io_context context;
  boost::system::error_code error;
  auto found = tcp::resolver(context).resolve(
      host, listen.substr(colon + 1), tcp::resolver::passive | tcp::resolver::numeric_service,
      error);
  if (error || found.empty()) {
    return core::InvalidArgument("expected HOST:PORT, got '{}': {}", listen, error.message());
  }
  return found;
}

absl::Status CannotListen(const std::string& listen, const boost::system::error_code& error) {
  const std::string message = fmt::format("cannot listen on {}: {}", listen, error.message());
  return error == asio::error::address_family_not_supported || error.value() == EADDRNOTAVAIL
             ? absl::NotFoundError(message)
             : absl::UnavailableError(message);
}

}  // namespace

absl::Status ListenOn(const std::string& listen, tcp::acceptor& acceptor) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto found, Resolve(listen));
  const tcp::endpoint endpoint = found.begin()->endpoint();
  boost::system::error_code error;
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  return error ? CannotListen(listen, error) : absl::OkStatus();
}

absl::Status CheckListening(const std::string& listen) {
  asio::io_context context;
  tcp::acceptor acceptor(context);
  return ListenOn(listen, acceptor);
}

absl::StatusOr<std::vector<std::string>> ResolveAddresses(const std::string& listen) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto found, Resolve(listen));
  std::vector<std::string> addresses;
  for (const auto& entry : found) {
    const asio::ip::address address = entry.endpoint().address();
    addresses.push_back(
        fmt::format(fmt::runtime(address.is_v6() ? "[{}]" : "{}"), address.to_string()));
  }
  return addresses;
}

}  // namespace motiondb::server
