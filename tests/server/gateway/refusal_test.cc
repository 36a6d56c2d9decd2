// Requests that are refused before they reach gRPC: in the metrics and with a request id, as calls.
#include <catch2/catch.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/error.pb.h"
#include "motiondb/v1/server.grpc.pb.h"
#include "tests/server/gateway/web_client.h"
#include "tests/server/gateway/web_server.h"

namespace motiondb::tests::refusal_test {
namespace {

using nlohmann::json;

constexpr char kGet[] = "/motiondb.v1.DatabaseService/GetDatabase";
constexpr char kVerify[] = "/motiondb.v1.StoreService/VerifyStore";
const std::pair<std::string, std::string> kJson{"Content-Type", "application/json"};
const std::pair<std::string, std::string> kId{"x-request-id", "my-id"};

// Errors by method and code, "DatabaseService.GetDatabase 3".
using Errors = std::map<std::string, std::int64_t>;

Errors ErrorsOf(WebServer& server) {
  const auto stub = server->NewStub<v1::ServerService>();
  const auto answer = Ask(*stub, &v1::ServerService::Stub::GetServerStatus, {});
  REQUIRE(answer.status.ok());
  Errors errors;
  for (const v1::MethodStatus& method : answer.response.methods()) {
    for (const v1::CodeCount& error : method.errors()) {
      errors[method.method() + " " + std::to_string(error.code())] = error.call_count();
    }
  }
  return errors;
}

std::string RequestIdIn(const json& error) {
  for (const json& detail : error.at("details")) {
    if (detail.at("type") == "google.rpc.RequestInfo") return detail["debug"]["requestId"];
  }
  return "";
}

TEST_CASE("Gateway: refused requests are counted and have a request id", "[server][gateway]") {
  WebServer server;
  server->options().max_message_bytes = 1 << 20;
  server->Restart();
  const auto refused = [&](int status, const Headers& headers, const std::string& body) {
    const HttpReply reply = Post(server.address(), kGet, headers, body);
    CHECK(reply.status == status);
    CHECK(RequestIdIn(json::parse(reply.body)) == "my-id");
  };
  refused(400, {kJson, kId}, "{");
  refused(400, {kJson, kId, {"Connect-Timeout-Ms", "soon"}}, "{}");
  refused(415, {{"Content-Type", "text/plain"}, kId}, "{}");
  refused(413, {kJson, kId}, std::string(3 << 20, ' '));
  refused(403, {kJson, kId, {"Host", "evil.example"}}, "{}");
  refused(504, {kJson, kId, {"Connect-Timeout-Ms", "0"}}, "{}");
  const HttpReply stream =
      Post(server.address(), kVerify, {{"Content-Type", "application/connect+json"}, kId},
           "not enveloped");
  CHECK(RequestIdIn(json::parse(Envelopes(stream.body).at(0).second)["error"]) == "my-id");
  // A path that is no RPC is no call.
  CHECK(Post(server.address(), "/motiondb.v1.DatabaseService/Get", {kJson, kId}, "{}").status ==
        404);
  CHECK(ErrorsOf(server) == Errors{{"DatabaseService.GetDatabase 3", 3},
                                   {"DatabaseService.GetDatabase 4", 1},
                                   {"DatabaseService.GetDatabase 7", 1},
                                   {"DatabaseService.GetDatabase 8", 1},
                                   {"StoreService.VerifyStore 3", 1}});
}

TEST_CASE("HTTP/2: refused calls are counted and have a request id", "[server][transport]") {
  WebServer server;
  server->options().max_message_bytes = 1 << 20;
  server->Restart();
  v1::GetDatabaseRequest request;
  request.set_name(std::string(2 << 20, 'x'));
  v1::GetDatabaseResponse response;
  grpc::ClientContext context;
  context.AddMetadata("x-request-id", "my-id");
  const grpc::Status status =
      server->NewStub<v1::DatabaseService>()->GetDatabase(&context, request, &response);
  CHECK(status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED);
  v1::Status details;
  REQUIRE(details.ParseFromString(status.error_details()));
  std::string id;
  for (const auto& detail : details.details()) {
    v1::RequestInfo info;
    if (detail.type_url().ends_with("RequestInfo") && info.ParseFromString(detail.value())) {
      id = info.request_id();
    }
  }
  CHECK(id == "my-id");
  CHECK(ErrorsOf(server) == Errors{{"DatabaseService.GetDatabase 8", 1}});
}

}  // namespace
}  // namespace motiondb::tests::refusal_test
