// Tokens, TLS files and request ids of the client.
#include <grpcpp/security/credentials.h>
#include <motiondb/client.h>
#include <motiondb/v1/access.pb.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/error.pb.h>

#include <catch2/catch.hpp>
#include <chrono>

#include "tests/client/connect.h"
#include "tests/client/fake_server.h"
#include "tests/client/temporary_folder.h"

namespace motiondb::tests::access_test {
namespace {

using Catch::Contains;
using client::Client;
using client::ClientOptions;

std::string Refusal(const ClientOptions& options) {
  const absl::Status status = Client::Connect(options).status();
  CHECK(absl::IsInvalidArgument(status));
  return std::string(status.message());
}

TEST_CASE("Client: every call has the token and a unique request id", "[client]") {
  FakeServer server;
  server.Answer("ListDatabases", v1::ListDatabasesResponse());
  ClientOptions options;
  options.server = server.address();
  options.token = "mdb_1f_00";
  const auto client = Client::Connect(options);
  REQUIRE(client.ok());
  REQUIRE(client->ListDatabases({}).ok());
  REQUIRE(client->ListDatabases({}).ok());
  const auto headers = server.HeadersOf("ListDatabases");
  REQUIRE(headers.size() == 2);
  CHECK(headers[0].at("authorization") == "Bearer mdb_1f_00");
  CHECK(headers[0].at("x-request-id").size() == 16);
  CHECK(headers[0].at("x-request-id") != headers[1].at("x-request-id"));
  REQUIRE(ConnectTo(server.address()).ListDatabases({}).ok());
  CHECK(!server.HeadersOf("ListDatabases")[2].contains("authorization"));
}

TEST_CASE("Client: a token is not sent in plain text to another machine", "[client]") {
  ClientOptions options;
  options.token = "mdb_1f_00";
  for (const char* server : {"robot:50051", "10.0.0.1:50051", "127.0.0.1.example:1"}) {
    options.server = server;
    CHECK_THAT(Refusal(options), Contains("plain text") && Contains(server));
    CHECK_THAT(Refusal(options), !Contains("mdb_1f"));
  }
  options.server = "127.0.0.1:1";
  options.token = "two words";
  CHECK_THAT(Refusal(options), Contains("spaces") && !Contains("two words"));
  options.token = "mdb_1f_00";
  options.credentials = grpc::InsecureChannelCredentials();
  CHECK_THAT(Refusal(options), Contains("credentials"));
}

TEST_CASE("Client: errors name invalid TLS files", "[client]") {
  const TemporaryFolder folder;
  ClientOptions options;
  options.tls = client::TlsOptions{.ca_file = "/nonexistent/ca.crt"};
  CHECK_THAT(Refusal(options), Contains("TLS authority: /nonexistent/ca.crt: no such file"));
  options.tls->ca_file = folder.Write("ca.crt", "nonsense").string();
  CHECK_THAT(Refusal(options), Contains("ca.crt: expected PEM"));
  options.tls = client::TlsOptions{.certificate_file = "a.crt"};
  CHECK_THAT(Refusal(options), Contains("together"));
}

// Returns grpc-status-details-bin with a request id, a retry delay and a reason.
std::string Details(const std::string& request_id, int retry_seconds) {
  v1::Status status;
  v1::RequestInfo info;
  info.set_request_id(request_id);
  auto* detail = status.add_details();
  detail->set_type_url("type.googleapis.com/google.rpc.RequestInfo");
  detail->set_value(info.SerializeAsString());
  v1::RetryInfo retry;
  retry.mutable_retry_delay()->set_seconds(retry_seconds);
  detail = status.add_details();
  detail->set_type_url("type.googleapis.com/google.rpc.RetryInfo");
  detail->set_value(retry.SerializeAsString());
  v1::ErrorInfo reason;
  reason.set_reason("SOME_REASON");
  detail = status.add_details();
  detail->set_type_url("type.googleapis.com/google.rpc.ErrorInfo");
  detail->set_value(reason.SerializeAsString());
  return status.SerializeAsString();
}

// INVALID_ARGUMENT, NOT_FOUND, ALREADY_EXISTS, FAILED_PRECONDITION, OUT_OF_RANGE.
constexpr int kAboutTheRequest[] = {3, 5, 6, 9, 11};
// CANCELLED, UNKNOWN, DEADLINE_EXCEEDED, PERMISSION_DENIED, RESOURCE_EXHAUSTED, ABORTED,
// UNIMPLEMENTED, INTERNAL, DATA_LOSS, UNAUTHENTICATED.
constexpr int kNotAboutIt[] = {1, 2, 4, 7, 8, 10, 12, 13, 15, 16};

TEST_CASE("Client: an error has the request id, in its message unless the request is wrong",
          "[client]") {
  FakeServer server;
  server.Fail("GetDatabase", 13, "a bug", Details("robot/1", 0));
  server.Fail("GetDatabase", 14, "the server is stopping", Details("robot/2", 0));
  server.Fail("GetDatabase", 8, "too many calls", Details("robot/3", 7));
  server.Fail("GetDatabase", 5, "no such database");
  for (const int code : kAboutTheRequest) server.Fail("GetDatabase", code, "no", Details("id", 0));
  for (const int code : kNotAboutIt) server.Fail("GetDatabase", code, "no", Details("id", 0));
  const Client client = ConnectTo(server.address());
  const absl::Status bug = client.GetDatabase({}).status();
  CHECK(std::string(bug.message()) == "a bug (request robot/1)");
  CHECK(client::RequestId(bug) == "robot/1");
  const absl::Status stopping = client.GetDatabase({}).status();
  CHECK_THAT(std::string(stopping.message()),
             Contains("the server is stopping (request robot/2)") && Contains(server.address()));
  CHECK(client::RequestId(stopping) == "robot/2");
  const absl::Status busy = client.GetDatabase({}).status();
  CHECK(std::string(busy.message()) == "too many calls (request robot/3)");
  CHECK(client::RequestId(busy) == "robot/3");
  CHECK(client::RetryDelay(busy) == std::chrono::seconds(7));
  CHECK(client::ErrorReason(busy) == "SOME_REASON");
  const absl::Status plain = client.GetDatabase({}).status();
  CHECK(!client::RetryDelay(plain).has_value());
  CHECK(client::ErrorReason(plain).empty());
  for (const int code : kAboutTheRequest) {
    CAPTURE(code);
    const absl::Status status = client.GetDatabase({}).status();
    CHECK(std::string(status.message()) == "no");
    CHECK(client::RequestId(status) == "id");
  }
  for (const int code : kNotAboutIt) {
    CAPTURE(code);
    CHECK(std::string(client.GetDatabase({}).status().message()) == "no (request id)");
  }
}

}  // namespace
}  // namespace motiondb::tests::access_test
