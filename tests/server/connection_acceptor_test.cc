#include "server/connection_acceptor.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <future>

namespace motiondb::tests {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

TEST_CASE("ConnectionAcceptor: hands over what connects, at each address of a name",
          "[server][rpc]") {
  std::promise<int> taken;
  const auto take = [&](int connection, int) { taken.set_value(connection); };
  auto acceptor = server::ConnectionAcceptor::Start("localhost:0", take);
  REQUIRE(acceptor.ok());
  const auto port = static_cast<unsigned short>((*acceptor)->port());
  asio::io_context context;
  std::vector<tcp::endpoint> addresses = {{asio::ip::address_v4::loopback(), port}};
  // Where the name has this address too, and the machine.
  boost::system::error_code error;
  tcp::socket probe(context);
  const tcp::endpoint v6{asio::ip::address_v6::loopback(), port};
  for (const auto& entry : tcp::resolver(context).resolve("localhost", "0")) {
    const bool bound = entry.endpoint().address().is_v6() && !probe.open(tcp::v6(), error) &&
                       !probe.bind({asio::ip::address_v6::loopback(), 0}, error);
    if (bound) addresses.push_back(v6);
    probe.close();
  }
  for (const tcp::endpoint& address : addresses) {
    INFO(address);
    tcp::socket client(context);
    client.connect(address);
    const int connection = taken.get_future().get();
    REQUIRE(write(connection, "x", 1) == 1);
    char byte = 0;
    CHECK(client.read_some(asio::buffer(&byte, 1)) == 1);
    close(connection);
    taken = {};
  }
  acceptor->reset();
  tcp::socket late(context);
  late.connect(addresses.front(), error);
  CHECK(error == asio::error::connection_refused);
}

TEST_CASE("ConnectionAcceptor: an address that another has is told", "[server][rpc]") {
  const auto ignore = [](int connection, int) { close(connection); };
  const auto first = server::ConnectionAcceptor::Start("127.0.0.1:0", ignore);
  REQUIRE(first.ok());
  const std::string address = "127.0.0.1:" + std::to_string((*first)->port());
  CHECK(absl::IsUnavailable(server::ConnectionAcceptor::Start(address, ignore).status()));
  CHECK(absl::IsNotFound(server::ConnectionAcceptor::Start("192.0.2.1:0", ignore).status()));
}

}  // namespace
}  // namespace motiondb::tests
