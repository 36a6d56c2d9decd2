#include "server/http2/grpc_wire.h"

#include <catch2/catch.hpp>
#include <string>

#include "absl/strings/escaping.h"

namespace motiondb::tests::grpc_wire_test {
namespace {

using namespace std::chrono_literals;
using server::ParseTimeout;

TEST_CASE("gRPC wire: a message prefix keeps every length", "[server][http2]") {
  for (const std::uint32_t length : {0U, 1U, 255U, 256U, 65'536U, 16'777'216U, 4'294'967'295U}) {
    const server::MessagePrefix prefix = server::MakeMessagePrefix(length);
    CHECK(server::MessageLength(prefix) == length);
    CHECK(!server::IsCompressed(prefix));
  }
  CHECK(server::IsCompressed({1, 0, 0, 0, 0}));
}

TEST_CASE("gRPC wire: timeouts in every unit; other texts are malformed", "[server][http2]") {
  CHECK(ParseTimeout("250m") == 250ms);
  CHECK(ParseTimeout("1S") == 1s);
  CHECK(ParseTimeout("2M") == 2min);
  CHECK(ParseTimeout("3H") == 3h);
  CHECK(ParseTimeout("4u") == 4us);
  CHECK(ParseTimeout("99999999n") == 99'999'999ns);
  CHECK(ParseTimeout("0n") == 0ns);
  CHECK(ParseTimeout("99999999H").has_value());  // clamped, no overflow
  CHECK(*ParseTimeout("99999999H") > 24h * 365);
  for (const char* const wrong :
       {"", "1", "S", "1s", "-1S", "+1S", " 1S", "1 S", "1.5S", "1Sm", "0x1S", "123456789S"}) {
    INFO(wrong);
    CHECK(!ParseTimeout(wrong).has_value());
  }
}

TEST_CASE("gRPC wire: trailers carry code, text and details", "[server][http2]") {
  using Trailers = server::HeaderList;
  CHECK(server::MakeTrailers(grpc::Status::OK) == Trailers{{"grpc-status", "0"}});
  const std::string details("\x08\x03\xff\0x", 5);
  const grpc::Status status(grpc::StatusCode::NOT_FOUND, "100 % of \xc3\xa9\n", details);
  const Trailers trailers = server::MakeTrailers(status);
  REQUIRE(trailers.size() == 3);
  CHECK(trailers[0] == std::pair<std::string, std::string>{"grpc-status", "5"});
  CHECK(trailers[1] == std::pair<std::string, std::string>{"grpc-message", "100 %25 of %C3%A9%0A"});
  CHECK(trailers[2].first == "grpc-status-details-bin");
  CHECK(trailers[2].second.find('=') == std::string::npos);
  std::string decoded;
  REQUIRE(absl::Base64Unescape(trailers[2].second, &decoded));
  CHECK(decoded == details);
}

TEST_CASE("gRPC wire: metadata for gRPC is printable ASCII", "[server][http2]") {
  CHECK(server::PrintableAscii("Bearer a b~") == "Bearer a b~");
  CHECK(server::PrintableAscii("a\tb\x7f\xc3\xa9") == "a?b???");
}

}  // namespace
}  // namespace motiondb::tests::grpc_wire_test
