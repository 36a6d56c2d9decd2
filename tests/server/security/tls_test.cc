// A server in this process, by TLS: who is let in, and what a change of the files does.
#include <grpcpp/create_channel.h>
#include <spdlog/spdlog.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <thread>

#include "motiondb/v1/access.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "server/security/key_pair.h"
#include "server/server.h"
#include "storage/sqlite/sqlite_motion_store.h"
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

  // How a call ends on a new connection that trusts `authority` and shows `own`.
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
    // Until it is connected or refused, however slow the machine.
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
  // As Connects, within a time in which the server sees its files change.
  bool ComesToConnect(const Authority& authority, const KeyPairFiles& own = {}) {
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

TEST_CASE("TLS: a connection needs an authority that vouches for the server", "[security]") {
  TlsServer server(false);
  CHECK(server.Call(server.servers).ok());
  CHECK(!server.Connects(server.clients));
  const auto plain =
      grpc::CreateChannel(server.server->address(), grpc::InsecureChannelCredentials());
  CHECK(!plain->WaitForConnected(std::chrono::system_clock::now() + milliseconds(500)));
}

TEST_CASE("TLS: new certificates are taken while the server runs, bad ones are not", "[security]") {
  TlsServer server(false);
  const Authority next(server.directory / "", "next");
  REQUIRE(server.Connects(server.servers));
  CHECK(!server.Connects(next));

  // A key that is not the certificate's, for longer than the server takes to look.
  const KeyPairFiles other = next.Issue("other", "localhost");
  const std::string good_key = ReadFile(server.pair.key);
  std::filesystem::copy_file(other.key, server.pair.key,
                             std::filesystem::copy_options::overwrite_existing);
  std::this_thread::sleep_for(seconds(3));
  CHECK(server.Connects(server.servers));
  std::ofstream(server.pair.key) << "no key at all";
  std::this_thread::sleep_for(milliseconds(2500));
  CHECK(server.Connects(server.servers));

  next.Issue("server", "localhost");
  CHECK(server.ComesToConnect(next));
  CHECK(!server.Connects(server.servers));
}

TEST_CASE("TLS: figures tell when the first of the served certificates ends, also of new ones",
          "[security]") {
  TlsServer server(false);
  const auto ends_in_days = [&] {
    const auto end = server.server->monitor().Figures().certificate_end_time_s;
    return static_cast<double>(end - std::time(nullptr)) / 86'400;
  };
  CHECK(ends_in_days() == Approx(2).margin(0.1));  // as Authority::Issue makes them
  // The authority's own certificate, which ends in two days, is served behind one that lasts.
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

TEST_CASE("TLS: of the server's certificate and its clients' authority, the first to end is told",
          "[security]") {
  const TemporaryDirectory directory;
  const Authority servers(directory / "", "servers");
  const Authority clients(directory / "", "clients");  // ends in two days
  const auto first_of = [&](int days, const std::string& client_ca) {
    const KeyPairFiles pair = servers.Issue("server", "localhost", days);
    const auto texts = server::ReadTlsFiles(
        {.certificate = pair.certificate, .key = pair.key, .client_ca = client_ca});
    REQUIRE(texts.ok());
    return std::pair(
        texts->first_to_end == client_ca,
        std::lround(static_cast<double>(texts->end_time_s - std::time(nullptr)) / 86'400));
  };
  CHECK(first_of(300, "") == std::pair(false, 300L));
  CHECK(first_of(300, clients.certificate()) == std::pair(true, 2L));
  CHECK(first_of(1, clients.certificate()) == std::pair(false, 1L));
}

TEST_CASE("TLS: with an authority of clients, each shows a certificate and is known by it",
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

  // Another authority of clients, while the server runs.
  std::filesystem::copy_file(server.servers.certificate(), server.clients.certificate(),
                             std::filesystem::copy_options::overwrite_existing);
  CHECK(server.ComesToConnect(server.servers, stranger));
  CHECK(!server.Connects(server.servers, robot));
}

// OpenSSL writes its alerts by write(), which raises SIGPIPE where the client has gone.
TEST_CASE("TLS: a closed connection does not end a program with a server", "[security]") {
  std::signal(SIGPIPE, SIG_DFL);
  const TlsServer server(false);
  CHECK(std::raise(SIGPIPE) == 0);
}

}  // namespace
}  // namespace motiondb::tests::tls_test
