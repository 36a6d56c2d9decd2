// The Connect protocol at a real server: cases from its specification
// (connectrpc.com/docs/protocol).
#include <catch2/catch.hpp>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "motiondb/v1/database.pb.h"
#include "motiondb/v1/error.pb.h"
#include "server/gateway/http_content.h"
#include "tests/server/gateway/web_client.h"
#include "tests/server/gateway/web_server.h"

namespace motiondb::tests::protocol_test {
namespace {

using nlohmann::json;

constexpr char kList[] = "/motiondb.v1.DatabaseService/ListDatabases";
constexpr char kGet[] = "/motiondb.v1.DatabaseService/GetDatabase";
constexpr char kExport[] = "/motiondb.v1.ClipService/ExportClip";
constexpr char kIngest[] = "/motiondb.v1.ClipService/IngestClip";
constexpr char kObserve[] = "/motiondb.v1.ObserveService/Observe";

const std::pair<std::string, std::string> kJson{"Content-Type", "application/json"};
const std::pair<std::string, std::string> kStreamJson{"Content-Type", "application/connect+json"};

struct Case {
  const char* name;
  std::string method;
  std::string path;
  Headers headers;
  std::string body;
  int status;
  std::string code;     // of the Connect error; empty: success
  Headers fields = {};  // of the response
};

std::vector<Case> UnaryCases() {
  const std::string empty_zip = server::Gzip("{}");
  return {
      {"JSON", "POST", kList, {kJson}, "{}", 200, "", {{"content-type", "application/json"}}},
      {"JSON with a charset",
       "POST",
       kList,
       {{"Content-Type", "application/json; charset=utf-8"}},
       "{}",
       200,
       "",
       {{"content-type", "application/json"}}},
      {"content types ignore case",
       "POST",
       kList,
       {{"content-type", "Application/JSON"}},
       "{}",
       200,
       ""},
      {"proto",
       "POST",
       kList,
       {{"Content-Type", "application/proto"}},
       "",
       200,
       "",
       {{"content-type", "application/proto"}}},
      {"an empty body is the empty message", "POST", kList, {kJson}, "", 200, ""},
      {"an empty body is not decompressed",
       "POST",
       kList,
       {kJson, {"Content-Encoding", "gzip"}},
       "",
       200,
       ""},
      {"protocol version 1",
       "POST",
       kList,
       {kJson, {"Connect-Protocol-Version", "1"}},
       "{}",
       200,
       ""},
      {"other protocol version",
       "POST",
       kList,
       {kJson, {"Connect-Protocol-Version", "2"}},
       "{}",
       400,
       "invalid_argument"},
      {"timeout", "POST", kList, {kJson, {"Connect-Timeout-Ms", "5000"}}, "{}", 200, ""},
      {"timeout of ten digits",
       "POST",
       kList,
       {kJson, {"Connect-Timeout-Ms", "9999999999"}},
       "{}",
       200,
       ""},
      {"timeout of eleven digits",
       "POST",
       kList,
       {kJson, {"Connect-Timeout-Ms", "10000000000"}},
       "{}",
       400,
       "invalid_argument"},
      {"timeout without a number",
       "POST",
       kList,
       {kJson, {"Connect-Timeout-Ms", "1s"}},
       "{}",
       400,
       "invalid_argument"},
      {"negative timeout",
       "POST",
       kList,
       {kJson, {"Connect-Timeout-Ms", "-1"}},
       "{}",
       400,
       "invalid_argument"},
      {"gzip", "POST", kList, {kJson, {"Content-Encoding", "gzip"}}, empty_zip, 200, ""},
      {"identity", "POST", kList, {kJson, {"Content-Encoding", "identity"}}, "{}", 200, ""},
      {"unknown coding",
       "POST",
       kList,
       {kJson, {"Content-Encoding", "br"}},
       "{}",
       501,
       "unimplemented",
       {{"accept-encoding", "gzip"}}},
      {"no gzip data",
       "POST",
       kList,
       {kJson, {"Content-Encoding", "gzip"}},
       "{}",
       400,
       "invalid_argument"},
      {"unknown content type",
       "POST",
       kList,
       {{"Content-Type", "text/plain"}},
       "{}",
       415,
       "invalid_argument",
       {{"accept-post", "application/json, application/proto"}}},
      {"no content type", "POST", kList, {}, "{}", 415, "invalid_argument"},
      {"gRPC's content type",
       "POST",
       kList,
       {{"Content-Type", "application/grpc"}},
       "",
       415,
       "invalid_argument"},
      {"stream's content type for a unary method",
       "POST",
       kList,
       {kStreamJson},
       "{}",
       415,
       "invalid_argument"},
      {"unary content type for a stream",
       "POST",
       kExport,
       {kJson},
       "{}",
       415,
       "invalid_argument",
       {{"accept-post", "application/connect+json, application/connect+proto"}}},
      {"unary content type for a stream of requests",
       "POST",
       kIngest,
       {kJson},
       "{}",
       501,
       "unimplemented"},
      {"unknown method",
       "POST",
       "/motiondb.v1.DatabaseService/Nothing",
       {kJson},
       "{}",
       404,
       "unimplemented"},
      {"unknown service",
       "POST",
       "/motiondb.v1.NoService/Nothing",
       {kJson},
       "{}",
       404,
       "unimplemented"},
      {"other package",
       "POST",
       "/grpc.health.v1.Health/Check",
       {kJson},
       "{}",
       404,
       "unimplemented"},
      {"paths are case-sensitive",
       "POST",
       "/motiondb.v1.databaseservice/ListDatabases",
       {kJson},
       "{}",
       404,
       "unimplemented"},
      {"dots are no slashes",
       "POST",
       "/motiondb.v1/DatabaseService/ListDatabases",
       {kJson},
       "{}",
       404,
       "unimplemented"},
      {"root", "POST", "/", {kJson}, "{}", 404, "unimplemented"},
      {"query part", "POST", std::string(kList) + "?a=b", {kJson}, "{}", 200, ""},
      {"GET", "GET", kList, {}, "", 405, "unimplemented", {{"allow", "POST"}}},
      {"PUT", "PUT", kList, {kJson}, "{}", 405, "unimplemented", {{"allow", "POST"}}},
      {"OPTIONS",
       "OPTIONS",
       kList,
       {{"Origin", "http://a"}},
       "",
       405,
       "unimplemented",
       {{"allow", "POST"}}},
      {"no JSON", "POST", kList, {kJson}, "{", 400, "invalid_argument"},
      {"JSON of a list", "POST", kList, {kJson}, "[]", 400, "invalid_argument"},
      {"unknown field", "POST", kList, {kJson}, R"({"pageSizes":1})", 400, "invalid_argument"},
      {"wrong type", "POST", kList, {kJson}, R"({"pageSize":"x"})", 400, "invalid_argument"},
      {"camelCase", "POST", kList, {kJson}, R"({"pageSize":1})", 200, ""},
      {"names of the proto", "POST", kList, {kJson}, R"({"page_size":1})", 200, ""},
      {"invalid UTF-8", "POST", kGet, {kJson}, "{\"name\":\"\xff\xfe\"}", 400, "invalid_argument"},
      {"no protobuf",
       "POST",
       kGet,
       {{"Content-Type", "application/proto"}},
       "\x0a\xff",
       400,
       "invalid_argument"},
      {"not found", "POST", kGet, {kJson}, R"({"name":"databases/none"})", 404, "not_found"},
      {"invalid argument", "POST", kGet, {kJson}, R"({"name":"x"})", 400, "invalid_argument"},
      {"already exists",
       "POST",
       "/motiondb.v1.DatabaseService/CreateDatabase",
       {kJson},
       R"({"databaseId":"demo"})",
       409,
       "already_exists"},
      {"expired deadline",
       "POST",
       kList,
       {kJson, {"Connect-Timeout-Ms", "0"}},
       "{}",
       504,
       "deadline_exceeded"},
  };
}

TEST_CASE("Connect: unary requests", "[server][gateway]") {
  WebServer server;
  server->CreateDatabase("demo");
  auto client = std::make_unique<WebClient>(server.address());  // for all cases
  for (const Case& expected : UnaryCases()) {
    INFO(expected.name);
    REQUIRE(
        client->Send(HttpText(expected.method, expected.path, expected.headers, expected.body)));
    const HttpReply reply = client->Read();
    INFO(reply.body);
    if (expected.body.empty() || expected.status == 200) {
      CHECK(reply.Field("connection").empty());
    }
    REQUIRE(reply.status == expected.status);
    for (const auto& [name, value] : expected.fields) CHECK(reply.Field(name) == value);
    if (expected.code.empty()) {
      CHECK(reply.Field("content-type").starts_with("application/"));
    } else {
      CHECK(reply.Field("content-type") == "application/json");
      CHECK(json::parse(reply.body).at("code") == expected.code);
    }
    if (reply.Field("connection") == "close") {
      CHECK(client->ReadEnd());
      client = std::make_unique<WebClient>(server.address());
    }
  }
}

TEST_CASE("Connect: an error has its code, message and details", "[server][gateway]") {
  WebServer server;
  const HttpReply reply =
      Post(server.address(), kGet, {kJson, {"x-request-id", "my-id"}}, R"({"name":"x"})");
  CHECK(reply.status == 400);
  const json error = json::parse(reply.body);
  CHECK(error.at("code") == "invalid_argument");
  CHECK(!error.at("message").get<std::string>().empty());
  std::map<std::string, json> details;
  for (const json& detail : error.at("details")) details[detail.at("type")] = detail;
  REQUIRE(details.contains("google.rpc.ErrorInfo"));
  REQUIRE(details.contains("google.rpc.BadRequest"));
  REQUIRE(details.contains("google.rpc.RequestInfo"));
  CHECK(details["google.rpc.ErrorInfo"]["debug"]["domain"] == "motiondb");
  CHECK(details["google.rpc.BadRequest"]["debug"]["fieldViolations"][0]["field"] == "name");
  CHECK(details["google.rpc.RequestInfo"]["debug"]["requestId"] == "my-id");
  CHECK(details["google.rpc.RequestInfo"]["value"] == "CgVteS1pZA");  // without padding
}

struct StreamCase {
  const char* name;
  std::string path;
  Headers headers;
  std::string body;
  std::string code;
};

TEST_CASE("Connect: errors of streams", "[server][gateway]") {
  WebServer server;
  const std::string request = R"({"name":"databases/none/clips/none"})";
  const std::string zipped = server::Gzip(request);
  const std::vector<StreamCase> cases = {
      {"one message", kExport, {kStreamJson}, EnvelopeText(0, request), "not_found"},
      {"compressed",
       kExport,
       {kStreamJson, {"Connect-Content-Encoding", "gzip"}},
       EnvelopeText(1, zipped),
       "not_found"},
      {"declared, not compressed",
       kExport,
       {kStreamJson, {"Connect-Content-Encoding", "gzip"}},
       EnvelopeText(0, request),
       "not_found"},
      {"compressed, not declared",
       kExport,
       {kStreamJson},
       EnvelopeText(1, zipped),
       "invalid_argument"},
      {"unknown coding",
       kExport,
       {kStreamJson, {"Connect-Content-Encoding", "br"}},
       EnvelopeText(0, request),
       "unimplemented"},
      {"no message", kExport, {kStreamJson}, "", "invalid_argument"},
      {"two messages",
       kExport,
       {kStreamJson},
       EnvelopeText(0, request) + EnvelopeText(0, request),
       "invalid_argument"},
      {"reserved flags", kExport, {kStreamJson}, EnvelopeText(4, request), "invalid_argument"},
      {"end of stream", kExport, {kStreamJson}, EnvelopeText(2, "{}"), "invalid_argument"},
      {"truncated prefix", kExport, {kStreamJson}, std::string(3, '\0'), "invalid_argument"},
      {"truncated message",
       kExport,
       {kStreamJson},
       EnvelopeText(0, request).substr(0, 10),
       "invalid_argument"},
      {"huge length",
       kExport,
       {kStreamJson},
       std::string("\0\xff\xff\xff\xff{}", 7),
       "invalid_argument"},
      {"client stream", kIngest, {kStreamJson}, EnvelopeText(0, "{}"), "unimplemented"},
      {"bidirectional stream", kObserve, {kStreamJson}, EnvelopeText(0, "{}"), "unimplemented"},
      {"other version",
       kExport,
       {kStreamJson, {"Connect-Protocol-Version", "x"}},
       EnvelopeText(0, request),
       "invalid_argument"},
  };
  for (const StreamCase& expected : cases) {
    INFO(expected.name);
    const HttpReply reply = Post(server.address(), expected.path, expected.headers, expected.body);
    REQUIRE(reply.status == 200);
    CHECK(reply.Field("content-type") == "application/connect+json");
    const auto envelopes = Envelopes(reply.body);
    REQUIRE(envelopes.size() == 1);
    CHECK(envelopes[0].first == 2);
    INFO(envelopes[0].second);
    CHECK(json::parse(envelopes[0].second).at("error").at("code") == expected.code);
  }
}

}  // namespace
}  // namespace motiondb::tests::protocol_test
