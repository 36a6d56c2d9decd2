#include <catch2/catch.hpp>
#include <string>

#include "server/rpc/call_identity.h"

namespace motiondb::tests::peer_address_test {
namespace {

using server::AddressOf;

TEST_CASE("AddressOf: the peer's address without scheme and port", "[security]") {
  CHECK(AddressOf("ipv4:127.0.0.1:50000") == "127.0.0.1");
  CHECK(AddressOf("ipv6:[::1]:50000") == "::1");
  CHECK(AddressOf("ipv6:%5B2001:db8::1%5D:50000") == "2001:db8::1");
  CHECK(AddressOf("unix:/run/motiondb") == "unix");
  CHECK(AddressOf("unix:") == "unix");
  CHECK(AddressOf("strange") == "strange");
}

}  // namespace
}  // namespace motiondb::tests::peer_address_test
