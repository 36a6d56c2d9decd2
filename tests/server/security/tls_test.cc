// A server with TLS in this process: accepted clients, and changes of the files.
#include <grpcpp/create_channel.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <thread>

#include "motiondb/v1/access.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "server/security/operator_files.h"
#include "server/server.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/support/awaited_log.h"
#include "tests/support/certificates.h"
#include "tests/support/real_data.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::tls_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class TlsServer {
 public:
  explicit TlsServer(bool mutual) {
    spdlog::set_level(spdlog::level::off);
    server::ServerOptions options;
    options.listen = "127.0.0.1:0";
    options.engine.query_threads = 2;
    options.security.tls = {.certificate = pair.certificate, .key = pair.key};
    if (mutual) {
      options.security.tls.client_ca = clients.certificate();
      options.security.authentication = server::Authentication::kToken;
      options.security.certificate_role = storage::Role::kIngester;
    }
    auto store = storage::SqliteMotionStore::Open(directory / "store.db");
    REQUIRE(store.ok());
    auto started = server::Server::Start(*std::move(store), options);
    INFO(started.status().ToString());
    REQUIRE(started.ok());
    server = *std::move(started);
  }

  // Makes a call on a new connection that trusts `authority` and sends the certificate `own`.
  grpc::Status Call(const Authority& authority, const KeyPairFiles& own = {}) {
    grpc::SslCredentialsOptions pem{ReadFile(authority.certificate())};
    if (!own.key.empty()) {
      pem.pem_private_key = ReadFile(own.key);
      pem.pem_cert_chain = ReadFile(own.certificate);
    }
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    const auto channel =
        grpc::CreateCustomChannel(server->address(), grpc::SslCredentials(pem), arguments);
    // Until it is connected or refused, also on a slow machine.
    const auto end = std::chrono::system_clock::now() + seconds(20);
    auto state = channel->GetState(true);
    while (state != GRPC_CHANNEL_READY) {
      if (state == GRPC_CHANNEL_TRANSIENT_FAILURE || !channel->WaitForStateChange(state, end)) {
        return {grpc::StatusCode::UNAVAILABLE, "no connection"};
      }
      state = channel->GetState(true);
    }
    v1::CreateDatabaseRequest request;
    request.set_database_id("db");
    return Ask(*v1::DatabaseService::NewStub(channel), &v1::DatabaseService::Stub::CreateDatabase,
               request)
        .status;
  }
  bool Connects(const Authority& authority, const KeyPairFiles& own = {}) {
    return Call(authority, own).error_code() != grpc::StatusCode::UNAVAILABLE;
  }
  // Like Connects, repeated until the server has noticed a change of its files.
  bool ConnectsEventually(const Authority& authority, const KeyPairFiles& own = {}) {
    const auto end = std::chrono::steady_clock::now() + seconds(20);
    while (std::chrono::steady_clock::now() < end) {
      if (Connects(authority, own)) return true;
    }
    return false;
  }

  TemporaryDirectory directory;
  Authority servers{directory / "", "servers"};
  Authority clients{directory / "", "clients"};
  KeyPairFiles pair = servers.Issue("server", "localhost");
  std::unique_ptr<server::Server> server;
};

TEST_CASE("TLS: the client must trust the server's authority", "[security]") {
  TlsServer server(false);
  CHECK(server.Call(server.servers).ok());
  CHECK(!server.Connects(server.clients));
  const auto plain =
      grpc::CreateChannel(server.server->address(), grpc::InsecureChannelCredentials());
  CHECK(!plain->WaitForConnected(std::chrono::system_clock::now() + milliseconds(500)));
}

TEST_CASE("TLS: a running server loads new certificates, but not invalid ones", "[security]") {
  const AwaitedLog log;
  const std::string refused = "cannot reload";  // once for each new error
  TlsServer server(false);
  spdlog::set_level(spdlog::level::warn);
  const Authority next(server.directory / "", "next");
  REQUIRE(server.Connects(server.servers));
  CHECK(!server.Connects(next));

  // A key that does not match the certificate.
  const KeyPairFiles other = next.Issue("other", "localhost");
  std::filesystem::copy_file(other.key, server.pair.key,
                             std::filesystem::copy_options::overwrite_existing);
  CHECK(log.Await(refused));
  CHECK(server.Connects(server.servers));
  std::ofstream(server.pair.key) << "no key at all";
  CHECK(log.Await(refused, 2));
  CHECK(server.Connects(server.servers));

  next.Issue("server", "localhost");
  CHECK(server.ConnectsEventually(next));
  CHECK(!server.Connects(server.servers));
}

TEST_CASE("TLS: statistics have the first expiry of the served certificates, also of new ones",
          "[security]") {
  TlsServer server(false);
  const auto ends_in_days = [&] {
    const auto end = server.server->monitor().CollectStatistics().certificate_expiry_s;
    return static_cast<double>(end - std::time(nullptr)) / 86'400;
  };
  CHECK(ends_in_days() == Approx(2).margin(0.1));  // the validity by Authority::Issue
  // The chain has the authority's certificate, which expires in two days, after a longer one.
  server.servers.Issue("server", "localhost", 300);
  const auto await = [&](double days) {
    const auto latest = std::chrono::steady_clock::now() + seconds(20);
    while (std::abs(ends_in_days() - days) > 0.1) {
      REQUIRE(std::chrono::steady_clock::now() < latest);
      std::this_thread::sleep_for(milliseconds(20));
    }
  };
  await(300);
  CHECK_THAT(server.server->monitor().Exposition(),
             Catch::Contains("\nmotiondb_certificate_end_time_seconds "));
  const std::string chain =
      ReadFile(server.pair.certificate) + ReadFile(server.servers.certificate());
  std::ofstream(server.pair.certificate) << chain;
  await(2);
}

TEST_CASE("TLS: statistics have the first expiry of server certificate and client authority",
          "[security]") {
  const TemporaryDirectory directory;
  const Authority servers(directory / "", "servers");
  const Authority clients(directory / "", "clients");  // expires in two days
  const auto first_expiry = [&](int days, const std::string& client_ca) {
    const KeyPairFiles pair = servers.Issue("server", "localhost", days);
    const auto texts = server::ReadTlsFiles(
        {.certificate = pair.certificate, .key = pair.key, .client_ca = client_ca});
    REQUIRE(texts.ok());
    return std::pair(
        texts->first_to_end == client_ca,
        std::lround(static_cast<double>(texts->end_time_s - std::time(nullptr)) / 86'400));
  };
  CHECK(first_expiry(300, "") == std::pair(false, 300L));
  CHECK(first_expiry(300, clients.certificate()) == std::pair(true, 2L));
  CHECK(first_expiry(1, clients.certificate()) == std::pair(false, 1L));
}

TEST_CASE("TLS: with a client authority, each client is identified by its certificate",
          "[security]") {
  TlsServer server(true);
  const KeyPairFiles robot = server.clients.Issue("robot", "robot-7");
  const KeyPairFiles stranger = server.servers.Issue("stranger", "robot-7");
  CHECK(!server.Connects(server.servers));
  CHECK(!server.Connects(server.servers, stranger));
  const grpc::Status status = server.Call(server.servers, robot);
  CHECK(status.error_code() == grpc::StatusCode::PERMISSION_DENIED);
  CHECK(status.error_message() ==
        "DatabaseService.CreateDatabase needs the role admin; certificate:robot-7 has the role "
        "ingester");

  // Replaces the client authority while the server runs.
  std::filesystem::copy_file(server.servers.certificate(), server.clients.certificate(),
                             std::filesystem::copy_options::overwrite_existing);
  CHECK(server.ConnectsEventually(server.servers, stranger));
  CHECK(!server.Connects(server.servers, robot));
}

// OpenSSL writes alerts with write(), which raises SIGPIPE if the client has disconnected.
TEST_CASE("TLS: a closed connection does not end the process", "[security]") {
  std::signal(SIGPIPE, SIG_DFL);
  const TlsServer server(false);
  CHECK(std::raise(SIGPIPE) == 0);
}

}  // namespace
}  // namespace motiondb::tests::tls_test
