#include "server/observability/listen_on.h"

#include <boost/asio/io_context.hpp>
#include <catch2/catch.hpp>

namespace motiondb::tests {
namespace {

using boost::asio::ip::tcp;
using Catch::EndsWith;

TEST_CASE("ListenOn: what keeps an address from being listened on is told", "[server][http]") {
  boost::asio::io_context context;
  tcp::acceptor holder(context);
  REQUIRE(server::ListenOn("127.0.0.1:0", holder).ok());
  const std::string held = "127.0.0.1:" + std::to_string(holder.local_endpoint().port());
  const absl::Status in_use = server::WhyNotListening(held);
  CHECK(absl::IsUnavailable(in_use));
  CHECK(in_use.message() == "cannot listen on " + held + ": Address already in use");
  // Of a network that no machine is in (RFC 5737).
  const absl::Status elsewhere = server::WhyNotListening("192.0.2.1:0");
  CHECK(elsewhere.message() == "cannot listen on 192.0.2.1:0: Cannot assign requested address");
  tcp::acceptor acceptor(context);
  CHECK(absl::IsInvalidArgument(server::ListenOn("nothing", acceptor)));
  CHECK(absl::IsUnavailable(server::WhyNotListening("nothing")));
  // By then it may be free.
  holder.close();
  CHECK_THAT(std::string(server::WhyNotListening(held).message()),
             EndsWith("--log-level debug shows more"));
}

}  // namespace
}  // namespace motiondb::tests
