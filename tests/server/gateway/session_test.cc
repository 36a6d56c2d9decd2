// Login, logout and calls with the cookie: tokens, attributes of the cookie, requests of other
// sites, limits, the audit log, revocation.
#include <catch2/catch.hpp>
#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "motiondb/v1/access.grpc.pb.h"
#include "tests/server/gateway/web_client.h"
#include "tests/server/gateway/web_server.h"
#include "tests/support/captured_log.h"

namespace motiondb::tests::session_test {
namespace {

using nlohmann::json;

constexpr char kList[] = "/motiondb.v1.DatabaseService/ListDatabases";
constexpr char kAudit[] = "/motiondb.v1.AccessService/ListAuditEntries";
constexpr char kRevoke[] = "/motiondb.v1.AccessService/RevokeToken";
constexpr char kStatus[] = "/motiondb.v1.ServerService/GetServerStatus";
constexpr char kDelete[] = "/motiondb.v1.DatabaseService/DeleteDatabase";
constexpr char kWatch[] = "/motiondb.v1.DatabaseService/WatchDatabase";
const std::pair<std::string, std::string> kJson{"Content-Type", "application/json"};
const std::pair<std::string, std::string> kVersion{"Connect-Protocol-Version", "1"};

struct Tokens {
  std::string admin;
  std::string reader;  // of database a only
};

std::string MakeToken(WebServer& server, v1::Role role, const std::string& database = "") {
  v1::CreateTokenRequest request;
  request.mutable_token()->set_role(role);
  request.mutable_token()->set_database(database);
  const auto answer =
      Ask(*server->NewStub<v1::AccessService>(), &v1::AccessService::Stub::CreateToken, request);
  REQUIRE(answer.status.ok());
  return answer.response.secret();
}

// Makes tokens and requires them from now on.
Tokens RequireTokens(WebServer& server) {
  server->CreateDatabase("a");
  Tokens tokens{MakeToken(server, v1::ROLE_ADMIN),
                MakeToken(server, v1::ROLE_READER, "databases/a")};
  server->options().security.authentication = server::Authentication::kToken;
  server->Restart();
  return tokens;
}

HttpReply Login(WebServer& server, const std::string& token, Headers headers = {}) {
  headers.push_back(kJson);
  return Post(server.address(), "/login", headers, json({{"token", token}}).dump());
}

// Returns the header Cookie that a browser sends after a login.
std::pair<std::string, std::string> CookieOf(const HttpReply& login) {
  const std::string cookie = login.Field("set-cookie");
  return {"Cookie", cookie.substr(0, cookie.find(';'))};
}

json Session(WebServer& server, const Headers& headers) {
  WebClient client(server.address());
  client.Send(HttpText("GET", "/session", headers));
  const HttpReply reply = client.Read();
  CHECK(reply.status == 200);
  CHECK(reply.Field("cache-control") == "no-store");
  return json::parse(reply.body);
}

std::string Own(WebServer& server) { return server.address(); }
std::string HostOf(WebServer& server) {
  return server.address().substr(server.address().rfind('/') + 1);
}

TEST_CASE("Session: without authentication no token is needed", "[server][gateway]") {
  WebServer server;
  const json session = Session(server, {});
  CHECK(session["authenticationRequired"] == false);
  CHECK(session["authenticated"] == true);
  CHECK(session["principal"] == "anonymous");
  CHECK(session["role"] == "admin");
  CHECK(session["database"] == "");
  // A cookie from former times does not matter.
  CHECK(Post(server.address(), kList, {kJson, {"Cookie", "motiondb_token=abc"}}, "{}").status ==
        200);
}

TEST_CASE("Session: login, calls with the cookie, logout", "[server][gateway]") {
  WebServer server;
  const Tokens tokens = RequireTokens(server);
  json session = Session(server, {});
  CHECK(session == json({{"authenticationRequired", true}, {"authenticated", false}}));

  const HttpReply login = Login(server, tokens.reader);
  REQUIRE(login.status == 200);
  CHECK(login.body.find(tokens.reader) == std::string::npos);
  const std::string set = login.Field("set-cookie");
  CHECK_THAT(set, Catch::StartsWith("motiondb_token="));
  CHECK_THAT(set, Catch::EndsWith("; Path=/; HttpOnly; SameSite=Strict"));
  const auto cookie = CookieOf(login);
  session = Session(server, {cookie});
  CHECK(session == json::parse(login.body));
  CHECK(session["authenticated"] == true);
  CHECK(session["role"] == "reader");
  CHECK(session["database"] == "databases/a");
  CHECK_THAT(session["principal"].get<std::string>(), Catch::StartsWith("tokens/"));

  CHECK(Post(server.address(), kList, {kJson, kVersion, cookie}, "{}").status == 200);
  CHECK(Post(server.address(), kAudit, {kJson, kVersion, cookie}, "{}").status == 403);
  // The header counts more than the cookie.
  CHECK(Post(server.address(), kAudit, {kJson, cookie, {"Authorization", "Bearer " + tokens.admin}},
             "{}")
            .status == 200);
  CHECK(
      Post(server.address(), kList, {kJson, kVersion, cookie, {"Authorization", "Bearer x"}}, "{}")
          .status == 401);
  // Among other cookies.
  CHECK(Post(server.address(), kList,
             {kJson, kVersion, {"Cookie", "a=b; " + cookie.second + "; motiondb_token_2=x"}}, "{}")
            .status == 200);

  const HttpReply logout = Post(server.address(), "/logout", {cookie}, "");
  CHECK(logout.status == 200);
  CHECK_THAT(logout.Field("set-cookie"), Catch::StartsWith("motiondb_token=;"));
  CHECK_THAT(logout.Field("set-cookie"), Catch::EndsWith("Max-Age=0"));
}

TEST_CASE("Session: over HTTPS the cookie is bound to the host", "[server][gateway]") {
  // A proxy has the TLS: the browser's Origin tells.
  WebServer server;
  const Tokens tokens = RequireTokens(server);
  const std::pair<std::string, std::string> host{"Host", "motion.example"};
  const std::pair<std::string, std::string> origin{"Origin", "https://motion.example"};
  const HttpReply login = Login(server, tokens.admin, {host, origin});
  REQUIRE(login.status == 200);
  CHECK_THAT(login.Field("set-cookie"), Catch::StartsWith("__Host-motiondb_token="));
  CHECK_THAT(login.Field("set-cookie"), Catch::EndsWith("; Secure"));
  const auto cookie = CookieOf(login);
  CHECK(Post(server.address(), kList, {kJson, kVersion, cookie, host, origin}, "{}").status == 200);
}

TEST_CASE("Session: requests of other sites are refused", "[server][gateway]") {
  WebServer server;
  const Tokens tokens = RequireTokens(server);
  const auto cookie = CookieOf(Login(server, tokens.admin));
  const auto status = [&](Headers headers) {
    headers.push_back(kJson);
    headers.push_back(cookie);
    headers.emplace_back("Host", HostOf(server));
    const HttpReply reply = Post(server.address(), kList, headers, "{}");
    if (reply.status != 200) {
      CHECK(json::parse(reply.body)["code"] == "permission_denied");
      CHECK(reply.body.find("CROSS_SITE_REQUEST") != std::string::npos);
    }
    return reply.status;
  };
  CHECK(status({}) == 403);  // a call without the header of the protocol
  CHECK(status({kVersion}) == 200);
  CHECK(status({kVersion, {"Sec-Fetch-Site", "same-origin"}, {"Origin", Own(server)}}) == 200);
  for (const char* const site : {"cross-site", "same-site", "none", "x"}) {
    CHECK(status({kVersion, {"Sec-Fetch-Site", site}}) == 403);
    CHECK(status({kVersion, {"Sec-Fetch-Site", site}, {"Origin", Own(server)}}) == 403);
  }
  for (const std::string& origin :
       {std::string("https://evil.example"), std::string("null"), std::string("http://127.0.0.1"),
        std::string("http://127.0.0.1:1"), Own(server) + ".evil.example", Own(server) + "/",
        "ftp://" + HostOf(server), HostOf(server)}) {
    CHECK(status({kVersion, {"Origin", origin}}) == 403);
    CHECK(status({kVersion, {"Origin", origin}, {"Sec-Fetch-Site", "same-origin"}}) == 403);
  }
  // Streams have the same rule.
  const HttpReply stream =
      Post(server.address(), "/motiondb.v1.StoreService/VerifyStore",
           {{"Content-Type", "application/connect+json"}, cookie}, EnvelopeText(0, "{}"));
  CHECK(json::parse(Envelopes(stream.body).at(0).second)["error"]["code"] == "permission_denied");
  // A token in the header needs no such proof: other sites do not know it.
  CHECK(Post(server.address(), kList,
             {kJson, {"Authorization", "Bearer " + tokens.admin}, {"Origin", "https://a.example"}},
             "{}")
            .status == 200);
  // Other sites cannot log in or out.
  const std::pair<std::string, std::string> foreign{"Origin", "https://evil.example"};
  CHECK(Login(server, tokens.admin, {foreign}).status == 403);
  CHECK(Login(server, tokens.admin, {{"Sec-Fetch-Site", "same-site"}}).status == 403);
  CHECK(Post(server.address(), "/logout", {foreign}, "").status == 403);
  CHECK(Post(server.address(), "/login", {{"Content-Type", "text/plain"}},
             json({{"token", tokens.admin}}).dump())
            .status == 415);
}

TEST_CASE("Session: wrong logins are refused, limited and recorded", "[server][gateway]") {
  WebServer server;
  const Tokens tokens = RequireTokens(server);
  const CapturedLog log(spdlog::level::debug);
  for (const std::string& body :
       {std::string(), std::string("x"), std::string("[]"), std::string("{}"),
        std::string(R"({"token":1})"), std::string(R"({"token":""})"),
        std::string(R"({"token":"\u0000"})"), std::string("{\"token\":\"\xff\"}")}) {
    const HttpReply reply = Post(server.address(), "/login", {kJson}, body);
    CHECK((reply.status == 400 || reply.status == 401));
    CHECK(reply.Field("set-cookie").empty());
  }
  CHECK(Post(server.address(), "/login", {kJson}, std::string(5000, 'x')).status == 413);
  WebClient client(server.address());
  client.Send(HttpText("GET", "/login", {}));
  CHECK(client.Read().status == 405);
  const std::string wrong = "mdb_0123456789ab_" + std::string(64, 'f');
  int refused = 0;
  for (int i = 0; i < 15; ++i) {
    const HttpReply reply = Login(server, wrong);
    CHECK((reply.status == 401 || reply.status == 429));
    CHECK(reply.Field("set-cookie").empty());
    if (reply.status == 429) ++refused;
  }
  CHECK(refused > 3);
  // The right token still works.
  CHECK(Login(server, tokens.admin).status == 200);
  const json audit = json::parse(
      Post(server.address(), kAudit, {kJson, {"Authorization", "Bearer " + tokens.admin}}, "{}")
          .body);
  int failed = 0;
  int succeeded = 0;
  for (const json& entry : audit["entries"]) {
    if (entry["method"] != "Login") continue;
    CHECK(entry["peer"] == "127.0.0.1");
    (entry.value("code", 0) == 0 ? succeeded : failed)++;
  }
  CHECK(failed >= 8);
  CHECK(failed <= 10);
  CHECK(succeeded == 1);
  server->Stop();
  CHECK(log.text().find("a wrong token from 127.0.0.1") != std::string::npos);
  for (const std::string& secret : {wrong, tokens.admin}) {
    CHECK(audit.dump().find(secret) == std::string::npos);
    CHECK(log.text().find(secret) == std::string::npos);
  }
}

TEST_CASE("Session: a revoked token stops calls and streams", "[server][gateway]") {
  WebServer server;
  const Tokens tokens = RequireTokens(server);
  const auto cookie = CookieOf(Login(server, tokens.reader));
  const std::string name = Session(server, {cookie})["principal"];
  WebClient stream(server.address());
  stream.Send(HttpText("POST", kWatch,
                       {{"Content-Type", "application/connect+json"}, kVersion, cookie},
                       EnvelopeText(0, R"({"name":"databases/a"})")));
  const Headers admin = {kJson, {"Authorization", "Bearer " + tokens.admin}};
  const auto open_streams = [&] {
    return json::parse(Post(server.address(), kStatus, admin, "{}").body)
        .value("openStreamCount", 0);
  };
  while (open_streams() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  CHECK(Post(server.address(), kRevoke, admin, json({{"name", name}}).dump()).status == 200);
  CHECK(Post(server.address(), kList, {kJson, kVersion, cookie}, "{}").status == 401);
  CHECK(Login(server, tokens.reader).status == 401);
  WebClient client(server.address());
  client.Send(HttpText("GET", "/session", {cookie}));
  const HttpReply reply = client.Read();
  CHECK(json::parse(reply.body)["authenticated"] == false);
  CHECK(json::parse(reply.body)["reason"].get<std::string>().find("revoked") != std::string::npos);
  CHECK_THAT(reply.Field("set-cookie"), Catch::StartsWith("motiondb_token=;"));
  CHECK_THAT(reply.Field("set-cookie"), Catch::Contains(", __Host-motiondb_token=;"));
  CHECK_THAT(reply.Field("set-cookie"), Catch::EndsWith("Max-Age=0"));
  // The stream ends instead of sending the next change.
  CHECK(Post(server.address(), kDelete, admin, R"({"name":"databases/a"})").status == 200);
  const auto envelopes = Envelopes(stream.Read().body);
  REQUIRE(!envelopes.empty());
  CHECK(json::parse(envelopes.back().second)["error"]["code"] == "unauthenticated");
}

TEST_CASE("Session: hostile cookies", "[server][gateway]") {
  WebServer server;
  RequireTokens(server);
  for (const std::string& value :
       {std::string("motiondb_token"), std::string("motiondb_token="), std::string("=;=;;"),
        std::string("motiondb_token=%%%"), std::string("motiondb_token=AAAA"),
        "motiondb_token=" + std::string(4000, 'A'), std::string("motiondb_token=Cg0KDQ"),
        std::string("x=motiondb_token=abc"), std::string(2000, ';')}) {
    const int status =
        Post(server.address(), kList, {kJson, kVersion, {"Cookie", value}}, "{}").status;
    CHECK((status == 401 || status == 429));
  }
}

}  // namespace
}  // namespace motiondb::tests::session_test
