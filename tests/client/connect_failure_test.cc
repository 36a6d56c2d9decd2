// Error messages if there is no motiondb server, tested with other sockets.
#include <motiondb/client.h>

#include <catch2/catch.hpp>
#include <string>

#include "client/call_failure.h"
#include "tests/client/other_program.h"
#include "tests/client/run_motiondb.h"
#include "tests/support/project_paths.h"

namespace motiondb::tests::connect_failure_test {
namespace {

using Catch::Contains;
using Catch::StartsWith;
using client::ConnectFailure;

constexpr char kHttp[] = "HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n";

// Returns the program's error for an address: one line, without gRPC's log lines.
std::string ErrorOf(const std::string& address, const std::vector<std::string>& options = {}) {
  std::vector<std::string> arguments = {"list"};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const auto result = RunMotiondb(address, arguments);
  CHECK(result.exit_code == 1);
  CHECK_THAT(result.err,
             StartsWith("motiondb: no motiondb server answered at " + address + " within 2 s: "));
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  return result.err;
}

TEST_CASE("motiondb: nothing listens, or an unknown host", "[client][cli]") {
  CHECK_THAT(ErrorOf("127.0.0.1:1"),
             Contains("nothing listens there; start a server with `motiondbd "
                      "--listen 127.0.0.1:1`") &&
                 Contains("--server or MOTIONDB_SERVER"));
  CHECK_THAT(ErrorOf("unix:/nonexistent/socket"), Contains("nothing listens there"));
  // Too long for a host name, so that no name server is queried.
  CHECK_THAT(ErrorOf(std::string(64, 'a') + ".invalid:50051"),
             Contains("the host name cannot be resolved: Misformatted domain name; ") &&
                 Contains("--server"));
}

TEST_CASE("motiondb: the port of another program", "[client][cli]") {
  const OtherProgram web(kHttp);
  CHECK_THAT(ErrorOf(web.address()),
             Contains("does not use gRPC in plain text") && Contains("--tls"));
  CHECK_THAT(ErrorOf(web.address(), {"--tls"}), Contains("does not use TLS; omit --tls"));
  const OtherProgram silent("");
  CHECK_THAT(ErrorOf(silent.address()), Contains("no response; "));
  CHECK_THAT(ErrorOf(silent.address(), {"--tls"}), Contains("no response; "));
}

TEST_CASE("motiondb: GRPC_VERBOSITY enables the log of gRPC", "[client][cli]") {
  const OtherProgram web(kHttp);
  const auto result = RunProgram({"env", "GRPC_VERBOSITY=ERROR", MotiondbProgram(), "--server",
                                  web.address(), "--tls", "list"});
  CHECK_THAT(result.err, Contains("ssl_transport_security.cc"));
}

TEST_CASE("ConnectError: attaches the failure, passes unknown messages on", "[client]") {
  client::ClientOptions options;
  options.server = "robot:1";
  const absl::Status other = client::ConnectError(
      options, "failed to connect to all addresses; last error: UNKNOWN: ipv4:10.0.0.1:1: Odd");
  CHECK(absl::IsUnavailable(other));
  CHECK_THAT(std::string(other.message()), Contains("robot:1 within 2 s: UNKNOWN: ipv4") &&
                                               Contains("Odd") && !Contains("last error"));
  CHECK(client::AttachedConnectFailure(other) == ConnectFailure::kOther);
  CHECK(client::AttachedConnectFailure(client::ConnectError(options, "")) ==
        ConnectFailure::kNoResponse);
  CHECK(!client::AttachedConnectFailure(absl::UnavailableError("gone")).has_value());
}

}  // namespace
}  // namespace motiondb::tests::connect_failure_test
