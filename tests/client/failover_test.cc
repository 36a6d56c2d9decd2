// A client with the addresses of several servers.
#include <motiondb/client.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/error.pb.h>
#include <motiondb/v1/query.pb.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "tests/client/connect.h"
#include "tests/client/fake_server.h"
#include "tests/client/other_program.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"

namespace motiondb::tests::failover_test {
namespace {

using Catch::Contains;
using client::Client;
using client::ClientOptions;

constexpr int kUnavailable = 14;
constexpr char kNobody[] = "127.0.0.1:1";  // nothing listens there

// grpc-status-details-bin of a server that stops.
std::string StoppingDetails() {
  v1::ErrorInfo info;
  info.set_reason("SERVER_STOPPING");
  v1::Status status;
  status.set_code(kUnavailable);
  auto* detail = status.add_details();
  detail->set_type_url("type.googleapis.com/google.rpc.ErrorInfo");
  detail->set_value(info.SerializeAsString());
  return status.SerializeAsString();
}

struct TwoServers {
  TwoServers() : a(std::make_unique<FakeServer>()) {}

  std::string addresses() const { return a->address() + "," + b.address(); }
  std::size_t CallsOfA(const std::string& rpc) const { return a->HeadersOf(rpc).size(); }
  std::size_t CallsOfB(const std::string& rpc) const { return b.HeadersOf(rpc).size(); }

  std::unique_ptr<FakeServer> a;
  FakeServer b;
};

TEST_CASE("Failover: a read is made again at the next address, and later calls go there",
          "[client]") {
  TwoServers servers;
  servers.a->Fail("Recognize", kUnavailable, "the store is closed");
  servers.b.Answer("Recognize", v1::RecognizeResponse());
  const Client client = ConnectTo(servers.addresses());
  REQUIRE(client.Recognize({}).ok());
  REQUIRE(client.Recognize({}).ok());
  CHECK(servers.CallsOfA("Recognize") == 1);
  CHECK(servers.CallsOfB("Recognize") == 2);
  CHECK(servers.a->HeadersOf("Recognize")[0].at("x-request-id") ==
        servers.b.HeadersOf("Recognize")[0].at("x-request-id"));
}

TEST_CASE("Failover: a change that a server may have begun is not made again", "[client]") {
  TwoServers servers;
  servers.a->Fail("CreateDatabase", kUnavailable, "the connection was lost");
  servers.b.Answer("CreateDatabase", v1::CreateDatabaseResponse());
  const Client client = ConnectTo(servers.addresses());
  const absl::Status status = client.CreateDatabase({}).status();
  CHECK(absl::IsUnavailable(status));
  CHECK_THAT(std::string(status.message()),
             Contains("server at " + servers.a->address() + " is not available"));
  CHECK(servers.CallsOfB("CreateDatabase") == 0);
  CHECK(client.CreateDatabase({}).ok());  // the next one goes on
  CHECK(servers.CallsOfA("CreateDatabase") == 1);
}

TEST_CASE("Failover: a change that no server has begun is made at the next address", "[client]") {
  TwoServers servers;
  const Client client = ConnectTo(servers.addresses());
  v1::IngestClipResponse stored;
  stored.mutable_clip()->set_name("databases/walks/clips/a");
  servers.b.Answer("IngestClip", stored);
  servers.b.Answer("CreateDatabase", v1::CreateDatabaseResponse());
  const TemporaryFolder folder;
  const auto file = folder.Write("a.bvh", std::string(3 << 20, 'x'));
  SECTION("it stops") {
    servers.a->Fail("CreateDatabase", kUnavailable, "stops", StoppingDetails());
    servers.a->Fail("IngestClip", kUnavailable, "stops", StoppingDetails());
  }
  SECTION("nothing listens") {
    servers.a.reset();
    // Until the client knows it, a call may seem to be begun.
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
  // The first call of each section finds the server gone.
  const bool ingests_first = GENERATE(true, false);
  if (!ingests_first) CHECK(client.CreateDatabase({}).ok());
  CHECK(client.IngestFile({}, file).ok());
  const auto sent = servers.b.Requests<v1::IngestClipRequest>("IngestClip");
  REQUIRE(sent.size() == 4);
  CHECK(sent[0].header().file_name() == "a.bvh");
  std::string bytes;
  for (const auto& message : sent) bytes += message.file_block();
  CHECK(bytes == folder.Read("a.bvh"));
}

TEST_CASE("Failover: a stream is read again only before its first message", "[client]") {
  TwoServers servers;
  v1::PredictSeriesResponse message;
  servers.a->Fail("PredictSeries", kUnavailable, "gone");
  servers.b.Push("PredictSeries", {kUnavailable, "gone", "", {message.SerializeAsString()}});
  const Client client = ConnectTo(servers.addresses());
  int received = 0;
  const absl::Status status = client.PredictSeries({}, [&](const auto&) {
    ++received;
    return absl::OkStatus();
  });
  CHECK(absl::IsUnavailable(status));
  CHECK(received == 1);
  CHECK(servers.CallsOfA("PredictSeries") == 1);
  CHECK(servers.CallsOfB("PredictSeries") == 1);
}

TEST_CASE("Failover: the error names all addresses", "[client]") {
  TwoServers servers;
  servers.a->Fail("Recognize", kUnavailable, "one");
  servers.b.Fail("Recognize", kUnavailable, "two");
  const absl::Status status = ConnectTo(servers.addresses()).Recognize({}).status();
  CHECK_THAT(std::string(status.message()),
             Contains("servers at " + servers.a->address() + ", " + servers.b.address() +
                      " are not available (two"));
  CHECK(servers.CallsOfA("Recognize") == 1);
  CHECK(servers.CallsOfB("Recognize") == 1);
  const auto connecting = RunMotiondb(std::string(kNobody) + ",127.0.0.1:2", {"list"});
  CHECK_THAT(connecting.err, Contains("127.0.0.1:1 within 2 s: nothing listens") &&
                                 Contains("127.0.0.1:2 within 2 s: nothing listens"));
}

TEST_CASE("Failover: a read is made twice at a single address, which may be a proxy", "[client]") {
  FakeServer server;
  server.Fail("Recognize", kUnavailable, "motiondbd does not respond");
  server.Answer("Recognize", v1::RecognizeResponse());
  server.Fail("DeleteDatabase", kUnavailable, "motiondbd does not respond");
  const Client client = ConnectTo(server.address());
  CHECK(client.Recognize({}).ok());
  CHECK(absl::IsUnavailable(client.DeleteDatabase({}).status()));
  CHECK(server.HeadersOf("DeleteDatabase").size() == 1);
}

TEST_CASE("Failover: a call is made again at a single address while its server stops", "[client]") {
  FakeServer server;
  for (int i = 0; i < 5; ++i) {
    server.Fail("CreateDatabase", kUnavailable, "stops", StoppingDetails());
  }
  server.Answer("CreateDatabase", v1::CreateDatabaseResponse());
  CHECK(ConnectTo(server.address()).CreateDatabase({}).ok());
}

TEST_CASE("Failover: connecting prefers the first address that responds", "[client]") {
  TwoServers servers;
  servers.a->Answer("GetDatabase", v1::GetDatabaseResponse());
  servers.b.Answer("GetDatabase", v1::GetDatabaseResponse());
  CHECK(ConnectTo(servers.addresses()).GetDatabase({}).ok());
  CHECK(servers.CallsOfA("GetDatabase") == 1);
  const OtherProgram silent("");
  const auto begin = std::chrono::steady_clock::now();
  const Client client =
      ConnectTo(std::string(kNobody) + ",unix:/nonexistent/socket," + silent.address() + "," +
                "localhost" + servers.b.address().substr(servers.b.address().find(':')));
  CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(2));
  CHECK(client.GetDatabase({}).ok());
  CHECK(servers.CallsOfB("GetDatabase") == 1);
}

TEST_CASE("Failover: invalid addresses, and a token that would leave the machine", "[client]") {
  ClientOptions options;
  for (const char* const server : {"", ",", "a:1,", "a:1,,b:2"}) {
    CAPTURE(server);
    options.server = server;
    CHECK(absl::IsInvalidArgument(Client::Connect(options).status()));
  }
  options.server = "127.0.0.1:1,robot:1";
  options.token = "secret";
  const absl::Status status = Client::Connect(options).status();
  CHECK(absl::IsInvalidArgument(status));
  CHECK_THAT(std::string(status.message()), Contains("plain text"));
}

}  // namespace
}  // namespace motiondb::tests::failover_test
