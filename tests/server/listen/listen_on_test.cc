#include "server/listen/listen_on.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <catch2/catch.hpp>

namespace motiondb::tests::listen_on_test {
namespace {

using boost::asio::ip::tcp;

TEST_CASE("ListenOn: the error tells why listening fails", "[server][http]") {
  boost::asio::io_context context;
  tcp::acceptor holder(context);
  REQUIRE(server::ListenOn("127.0.0.1:0", holder).ok());
  const std::string address = "127.0.0.1:" + std::to_string(holder.local_endpoint().port());
  const absl::Status in_use = server::CheckListening(address);
  CHECK(absl::IsUnavailable(in_use));
  CHECK(in_use.message() == "cannot listen on " + address + ": Address already in use");
  // Of a network without machines (RFC 5737).
  const absl::Status elsewhere = server::CheckListening("192.0.2.1:0");
  CHECK(absl::IsNotFound(elsewhere));
  CHECK(elsewhere.message() == "cannot listen on 192.0.2.1:0: Cannot assign requested address");
  tcp::acceptor acceptor(context);
  CHECK(absl::IsInvalidArgument(server::ListenOn("nothing", acceptor)));
  holder.close();
  CHECK(server::CheckListening(address).ok());
}

TEST_CASE("ResolveAddresses: returns numeric addresses", "[server][http]") {
  using Addresses = std::vector<std::string>;
  CHECK(*server::ResolveAddresses("127.0.0.1:7") == Addresses{"127.0.0.1"});
  CHECK(*server::ResolveAddresses("[::1]:7") == Addresses{"[::1]"});
  const auto local = server::ResolveAddresses("localhost:7");
  REQUIRE(local.ok());
  CHECK(std::ranges::count(*local, "127.0.0.1") == 1);
  CHECK(absl::IsInvalidArgument(server::ResolveAddresses("7").status()));
}

}  // namespace
}  // namespace motiondb::tests::listen_on_test
