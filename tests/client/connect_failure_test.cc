// Error messages if there is no motiondb server, tested with other sockets.
#include <arpa/inet.h>
#include <motiondb/client.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <string>
#include <thread>

#include "client/call_failure.h"
#include "tests/client/run_motiondb.h"

namespace motiondb::tests::connect_failure_test {
namespace {

using Catch::Contains;
using Catch::StartsWith;
using client::ConnectFailure;

// A port that accepts connections, sends `greeting` and closes them. Without a greeting it never
// responds.
class OtherProgram {
 public:
  explicit OtherProgram(std::string greeting) : greeting_(std::move(greeting)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    listening_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    REQUIRE(bind(listening_, reinterpret_cast<sockaddr*>(&address), size) == 0);
    REQUIRE(listen(listening_, 16) == 0);
    getsockname(listening_, reinterpret_cast<sockaddr*>(&address), &size);
    address_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    if (!greeting_.empty()) thread_ = std::thread([this] { Greet(); });
  }
  OtherProgram(const OtherProgram&) = delete;
  OtherProgram& operator=(const OtherProgram&) = delete;
  ~OtherProgram() {
    shutdown(listening_, SHUT_RDWR);
    if (thread_.joinable()) thread_.join();
    close(listening_);
  }

  const std::string& address() const { return address_; }

 private:
  void Greet() const {
    for (int caller; (caller = accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC)) >= 0;) {
      char asked[4096];
      static_cast<void>(!read(caller, asked, sizeof(asked)));
      static_cast<void>(!write(caller, greeting_.data(), greeting_.size()));
      shutdown(caller, SHUT_WR);
      static_cast<void>(!read(caller, asked, sizeof(asked)));
      close(caller);
    }
  }

  const std::string greeting_;
  int listening_ = -1;
  std::string address_;
  std::thread thread_;
};

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
  const auto result = RunProgram(
      {"env", "GRPC_VERBOSITY=ERROR", MOTIONDB_CLI, "--server", web.address(), "--tls", "list"});
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
