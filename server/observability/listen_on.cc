#include "server/observability/listen_on.h"

#include <boost/asio/io_context.hpp>

#include "core/motion/error.h"

namespace motiondb::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

absl::StatusOr<tcp::endpoint> Resolve(const std::string& listen) {
  const std::size_t colon = listen.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == listen.size()) {
    return core::InvalidArgument("expected HOST:PORT, got '{}'", listen);
  }
  std::string host = listen.substr(0, colon);
  if (host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  asio::io_context context;
  boost::system::error_code error;
  const auto found = tcp::resolver(context).resolve(
      host, listen.substr(colon + 1), tcp::resolver::passive | tcp::resolver::numeric_service,
      error);
  if (error || found.empty()) {
    return core::InvalidArgument("expected HOST:PORT, got '{}': {}", listen, error.message());
  }
  return found.begin()->endpoint();
}

absl::Status CannotListen(const std::string& listen, const std::string& why) {
  return absl::UnavailableError(fmt::format("cannot listen on {}: {}", listen, why));
}

}  // namespace

absl::Status ListenOn(const std::string& listen, tcp::acceptor& acceptor) {
  MOTIONDB_ASSIGN_OR_RETURN(const tcp::endpoint endpoint, Resolve(listen));
  boost::system::error_code error;
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  return error ? CannotListen(listen, error.message()) : absl::OkStatus();
}

absl::Status TryListening(const std::string& listen) {
  asio::io_context context;
  tcp::acceptor acceptor(context);
  return ListenOn(listen, acceptor);
}

absl::Status WhyNotListening(const std::string& listen) {
  const absl::Status status = TryListening(listen);
  if (status.ok()) {
    return CannotListen(listen, "gRPC does not say why; --log-level debug shows more");
  }
  return absl::IsUnavailable(status) ? status : CannotListen(listen, std::string(status.message()));
}

}  // namespace motiondb::server
