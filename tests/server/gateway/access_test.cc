// Authentication and identity of clients of the HTTP API.
#include <catch2/catch.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "motiondb/v1/access.grpc.pb.h"
#include "server/security/authorize.h"
#include "storage/access_store.h"
#include "tests/server/gateway/web_client.h"
#include "tests/server/gateway/web_server.h"
#include "tests/support/certificates.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests::access_test {
namespace {

using nlohmann::json;

constexpr char kList[] = "/motiondb.v1.DatabaseService/ListDatabases";
constexpr char kCreate[] = "/motiondb.v1.DatabaseService/CreateDatabase";
constexpr char kAudit[] = "/motiondb.v1.AccessService/ListAuditEntries";
const std::pair<std::string, std::string> kJson{"Content-Type", "application/json"};

std::string MakeToken(WebServer& server, v1::Role role) {
  v1::CreateTokenRequest request;
  request.mutable_token()->set_role(role);
  const auto stub = server->NewStub<v1::AccessService>();
  const auto answer = Ask(*stub, &v1::AccessService::Stub::CreateToken, request);
  REQUIRE(answer.status.ok());
  return answer.response.secret();
}

TEST_CASE("Gateway: calls need the tokens and roles of gRPC", "[server][gateway]") {
  WebServer server;
  const std::string reader = "Bearer " + MakeToken(server, v1::ROLE_READER);
  const std::string admin = "Bearer " + MakeToken(server, v1::ROLE_ADMIN);
  server->options().security.authentication = server::Authentication::kToken;
  server->Restart();
  const auto code = [&](const std::string& path, const Headers& headers, const std::string& body) {
    const HttpReply reply = Post(server.address(), path, headers, body);
    if (reply.status == 401) CHECK(reply.Field("www-authenticate") == "Bearer");
    const json answer = json::parse(reply.body);
    return std::to_string(reply.status) + " " +
           (answer.contains("code") ? answer["code"].get<std::string>() : "ok");
  };
  const std::string create = R"({"databaseId":"a"})";
  CHECK(code(kList, {kJson}, "{}") == "401 unauthenticated");
  CHECK(code(kList, {kJson, {"Authorization", "Bearer wrong"}}, "{}") == "401 unauthenticated");
  CHECK(code(kList, {kJson, {"Authorization", "Basic eDp5"}}, "{}") == "401 unauthenticated");
  CHECK(code(kList, {kJson, {"Authorization", reader}}, "{}") == "200 ok");
  CHECK(code(kCreate, {kJson, {"Authorization", reader}}, create) == "403 permission_denied");
  CHECK(code(kCreate, {kJson, {"Authorization", admin}}, create) == "200 ok");
  // A stream gets the same error at its end.
  const HttpReply stream =
      Post(server.address(), "/motiondb.v1.StoreService/VerifyStore",
           {{"Content-Type", "application/connect+json"}}, EnvelopeText(0, "{}"));
  CHECK(json::parse(Envelopes(stream.body).at(0).second)["error"]["code"] == "unauthenticated");
}

TEST_CASE("Gateway: clients cannot set their address or certificate", "[server][gateway]") {
  WebServer server;
  server->options().security.authentication = server::Authentication::kToken;
  server->options().security.certificate_role.reset();
  server->Restart();
  const Headers forged = {kJson,
                          {server::kPeerMetadata, "ipv4:6.6.6.6:1"},
                          {server::kCommonNameMetadata, "YWRtaW4"},
                          {"X-Forwarded-For", "6.6.6.6"},
                          {"Forwarded", "for=6.6.6.6"}};
  CHECK(Post(server.address(), kCreate, forged, "{}").status == 401);
  server->options().security.authentication = server::Authentication::kNone;
  server->Restart();
  CHECK(Post(server.address(), kCreate, forged, R"({"databaseId":"a"})").status == 200);
  const json audit = json::parse(Post(server.address(), kAudit, {kJson}, "{}").body);
  REQUIRE(!audit["entries"].empty());
  for (const json& entry : audit["entries"]) CHECK(entry["peer"] == "127.0.0.1");
}

// Sends a request with curl, which makes TLS connections. Returns the response.
json CurlOverTls(const std::string& address, const char* path, const std::string& body,
                 const Authority& authority, const KeyPairFiles* client = nullptr) {
  std::string command = "curl -sS --max-time 20 --cacert " + authority.certificate();
  if (client != nullptr) command += " --cert " + client->certificate + " --key " + client->key;
  command += " -H 'Content-Type: application/json' -d '" + body + "' " + address + path + " 2>&1";
  FILE* const pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::string text;
  char bytes[4096];
  while (const std::size_t size = fread(bytes, 1, sizeof(bytes), pipe)) text.append(bytes, size);
  pclose(pipe);
  INFO(text);
  const json answer = json::parse(text, nullptr, false);
  REQUIRE(!answer.is_discarded());
  return answer;
}

TEST_CASE("Gateway: a client certificate has the role of certificates", "[server][gateway]") {
  const TemporaryDirectory folder;
  const Authority authority(folder / "", "ca");
  const KeyPairFiles own = authority.Issue("server", "localhost");
  const KeyPairFiles robot = authority.Issue("robot", "robot-7");
  WebServer server;
  server::SecurityOptions& security = server->options().security;
  security.authentication = server::Authentication::kToken;
  security.tls = {own.certificate, own.key, authority.certificate()};
  security.certificate_role = storage::Role::kIngester;
  server->Restart();
  const auto call = [&](const char* path, const std::string& body, const KeyPairFiles* client) {
    return CurlOverTls(server.address(), path, body, authority, client);
  };
  CHECK(call(kList, "{}", &robot) == json::object());
  // An ingester cannot create databases.
  CHECK(call(kCreate, R"({"databaseId":"a"})", &robot)["code"] == "permission_denied");

  security.certificate_role = storage::Role::kAdmin;
  server->Restart();
  CHECK(call(kCreate, R"({"databaseId":"a"})", &robot)["database"]["name"] == "databases/a");
  const json audit = call(kAudit, "{}", &robot);
  REQUIRE(!audit["entries"].empty());
  CHECK(audit["entries"][0]["principal"] == "certificate:robot-7");
}

TEST_CASE("Gateway: names of other hosts are refused without authentication", "[server][gateway]") {
  WebServer server;
  const auto status = [&](const std::string& host) {
    return Post(server.address(), kList, {kJson, {"Host", host}}, "{}").status;
  };
  for (const char* const own :
       {"localhost", "localhost:80", "127.0.0.1:80", "127.0.0.1", "[::1]:8", "robot-7:8080",
        "robot.local", "motiondb.default.svc.cluster.local:80", "db.internal"}) {
    CHECK(status(own) == 200);
  }
  for (const bool any_address : {false, true}) {
    if (any_address) {
      // As in a container whose port is published on the loopback address of its host.
      server->options().security.insecure = true;
      server->options().web_listen = "0.0.0.0:0";
      server->Restart();
    }
    for (const char* const other :
         {"evil.example", "evil.example:80", "127.0.0.1.evil.example", "local.evil.example"}) {
      CHECK(status(other) == 403);
    }
  }
  server->options().security.authentication = server::Authentication::kToken;
  server->Restart();
  CHECK(status("motion.example") == 401);
}

TEST_CASE("Gateway: requests cannot break header lines", "[server][gateway]") {
  WebServer server;
  const HttpReply reply = Post(
      server.address(), kList,
      {kJson, {"x-request-id", "a\x01\xff"}, {"Authorization", std::string("Bearer \xc3\xa4")}},
      "{}");
  CHECK(reply.status == 400);  // no valid header
  CHECK(Post(server.address(), kList, {kJson, {"x-request-id", "\xc3\xa4"}}, "{}").status == 200);
}

}  // namespace
}  // namespace motiondb::tests::access_test
