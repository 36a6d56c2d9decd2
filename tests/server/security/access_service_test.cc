// Tokens by RPC: create, list, use, revoke.
#include <catch2/catch.hpp>
#include <chrono>
#include <string>

#include "motiondb/v1/access.grpc.pb.h"
#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/operation.grpc.pb.h"
#include "tests/support/captured_log.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::access_service_test {
namespace {

using Access = v1::AccessService::Stub;
using grpc::StatusCode;

v1::CreateTokenRequest TokenRequest(v1::Role role, const std::string& database = "") {
  v1::CreateTokenRequest request;
  request.mutable_token()->set_role(role);
  request.mutable_token()->set_database(database);
  return request;
}

Answer<v1::CreateTokenResponse> Make(TestServer& server, const v1::CreateTokenRequest& request,
                                     const std::string& token = "") {
  const auto stub = server.NewStub<v1::AccessService>();
  return Ask(*stub, &Access::CreateToken, request, token);
}

void RequireTokens(TestServer& server) {
  server.options().security.authentication = server::Authentication::kToken;
  server.Restart();
}

TEST_CASE("CreateToken: returns the token, and the secret once", "[security][rpc]") {
  TestServer server;
  server.CreateDatabase("walks");
  auto request = TokenRequest(v1::ROLE_INGESTER, "databases/walks");
  request.mutable_token()->set_description("the robot in the hall");
  request.mutable_ttl()->set_seconds(3600);
  const auto made = Make(server, request);
  INFO(made.status.error_message());
  REQUIRE(made.status.ok());
  const v1::Token& token = made.response.token();
  CHECK(token.name().starts_with("tokens/"));
  CHECK(token.role() == v1::ROLE_INGESTER);
  CHECK(token.database() == "databases/walks");
  CHECK(token.description() == "the robot in the hall");
  CHECK(token.expire_time().seconds() == token.create_time().seconds() + 3600);
  CHECK(!token.has_revoke_time());
  CHECK(made.response.secret().starts_with("mdb_" + token.name().substr(7) + "_"));

  const auto stub = server.NewStub<v1::AccessService>();
  const auto listed = Ask(*stub, &Access::ListTokens, v1::ListTokensRequest());
  REQUIRE(listed.status.ok());
  REQUIRE(listed.response.tokens_size() == 1);
  CHECK(listed.response.tokens(0).SerializeAsString() == token.SerializeAsString());
}

TEST_CASE("CreateToken: the error names the invalid field", "[security][rpc]") {
  TestServer server;
  auto request = TokenRequest(v1::ROLE_READER);
  CHECK(ViolatedFields(Make(server, TokenRequest(v1::ROLE_UNSPECIFIED)).status) == "token.role");
  CHECK(ViolatedFields(Make(server, TokenRequest(v1::ROLE_READER, "walks")).status) ==
        "token.database");
  CHECK(Make(server, TokenRequest(v1::ROLE_READER, "databases/none")).status.error_code() ==
        StatusCode::NOT_FOUND);
  request.mutable_ttl()->set_seconds(0);
  CHECK(ViolatedFields(Make(server, request).status) == "ttl");
  request.mutable_ttl()->set_seconds(-1);
  CHECK(ViolatedFields(Make(server, request).status) == "ttl");
  request.mutable_ttl()->set_seconds(std::int64_t{1} << 62);
  CHECK(ViolatedFields(Make(server, request).status) == "ttl");
  request.clear_ttl();
  request.mutable_token()->set_description(std::string(201, 'x'));
  CHECK(ViolatedFields(Make(server, request).status) == "token.description");
}

TEST_CASE("ListTokens: pages are in order of creation", "[security][rpc]") {
  TestServer server;
  std::vector<std::string> names;
  for (int i = 0; i < 5; ++i) {
    names.push_back(Make(server, TokenRequest(v1::ROLE_READER)).response.token().name());
  }
  const auto stub = server.NewStub<v1::AccessService>();
  std::vector<std::string> listed;
  v1::ListTokensRequest request;
  request.set_page_size(2);
  do {
    const auto page = Ask(*stub, &Access::ListTokens, request);
    REQUIRE(page.status.ok());
    CHECK(page.response.tokens_size() <= 2);
    for (const auto& token : page.response.tokens()) listed.push_back(token.name());
    request.set_page_token(page.response.next_page_token());
  } while (!request.page_token().empty());
  CHECK(listed == names);
}

TEST_CASE("RevokeToken: a token in use is invalid immediately and permanently", "[security][rpc]") {
  TestServer server;
  const auto admin = Make(server, TokenRequest(v1::ROLE_ADMIN)).response;
  const auto made = Make(server, TokenRequest(v1::ROLE_READER)).response;
  RequireTokens(server);
  const auto databases = server.NewStub<v1::DatabaseService>();
  const auto list = [&] {
    return Ask(*databases, &v1::DatabaseService::Stub::ListDatabases, v1::ListDatabasesRequest(),
               made.secret());
  };
  CHECK(list().status.ok());
  const auto stub = server.NewStub<v1::AccessService>();
  v1::RevokeTokenRequest request;
  request.set_name(made.token().name());
  const auto revoked = Ask(*stub, &Access::RevokeToken, request, admin.secret());
  REQUIRE(revoked.status.ok());
  CHECK(revoked.response.token().has_revoke_time());
  CHECK(list().status.error_code() == StatusCode::UNAUTHENTICATED);
  CHECK(list().status.error_message() == made.token().name() + " was revoked");
  const auto again = Ask(*stub, &Access::RevokeToken, request, admin.secret());
  CHECK(again.response.token().revoke_time().SerializeAsString() ==
        revoked.response.token().revoke_time().SerializeAsString());
  request.set_name("tokens/none");
  CHECK(Ask(*stub, &Access::RevokeToken, request, admin.secret()).status.error_code() ==
        StatusCode::NOT_FOUND);
}

TEST_CASE("RevokeToken: the last admin token stays, and the refusal is in the audit log",
          "[security][rpc]") {
  TestServer server;
  const auto admin = Make(server, TokenRequest(v1::ROLE_ADMIN)).response;
  RequireTokens(server);
  const auto stub = server.NewStub<v1::AccessService>();
  v1::RevokeTokenRequest request;
  request.set_name(admin.token().name());
  const grpc::Status refused = Ask(*stub, &Access::RevokeToken, request, admin.secret()).status;
  CHECK(refused.error_code() == StatusCode::FAILED_PRECONDITION);
  CHECK(refused.error_message().find(admin.token().name() + " is the last admin token") == 0);
  const auto audit =
      Ask(*stub, &Access::ListAuditEntries, v1::ListAuditEntriesRequest(), admin.secret());
  REQUIRE(audit.response.entries_size() == 2);
  CHECK(audit.response.entries(0).code() == static_cast<int>(StatusCode::FAILED_PRECONDITION));
  const auto second = Make(server, TokenRequest(v1::ROLE_ADMIN), admin.secret()).response;
  CHECK(Ask(*stub, &Access::RevokeToken, request, admin.secret()).status.ok());
  CHECK(!Ask(*stub, &Access::RevokeToken, request, admin.secret()).status.ok());
}

TEST_CASE("RevokeToken: a secret in the name is not in the audit log, log or error",
          "[security][rpc]") {
  TestServer server;
  const auto made = Make(server, TokenRequest(v1::ROLE_READER)).response;
  const std::string secret = made.secret().substr(made.secret().rfind('_') + 1);
  const auto stub = server.NewStub<v1::AccessService>();
  const CapturedLog log(spdlog::level::debug);
  for (const std::string& name : {"tokens/" + made.secret(), made.secret(),
                                  "tokens/" + made.secret() + "/x", "databases/" + made.secret()}) {
    INFO(name);
    v1::RevokeTokenRequest request;
    request.set_name(name);
    const grpc::Status status = Ask(*stub, &Access::RevokeToken, request).status;
    CHECK(ViolatedFields(status) == "name");
    CHECK(status.error_message().find("mdb_" + made.token().name().substr(7) + "_...") !=
          std::string::npos);
    CHECK(status.error_message().find(secret) == std::string::npos);
    CHECK(status.error_details().find(secret) == std::string::npos);
  }
  const auto audit = Ask(*stub, &Access::ListAuditEntries, v1::ListAuditEntriesRequest());
  REQUIRE(audit.response.entries_size() == 5);
  CHECK(audit.response.entries(3).resource() ==
        "tokens/mdb_" + made.token().name().substr(7) + "_...");
  CHECK(audit.response.DebugString().find(secret) == std::string::npos);
  server.Stop();
  CHECK(log.text().find("AccessService.RevokeToken") != std::string::npos);
  CHECK(log.text().find(secret) == std::string::npos);
}

TEST_CASE("Tokens of one database: lists show only that database", "[security][rpc]") {
  TestServer server;
  server.CreateDatabase("a");
  server.CreateDatabase("b");
  const auto ingested = server.IngestFigure("a", "walk", "walk", {});
  server.Wait(ingested.operation().name());
  const std::string token_a =
      Make(server, TokenRequest(v1::ROLE_READER, "databases/a")).response.secret();
  const std::string token_b =
      Make(server, TokenRequest(v1::ROLE_READER, "databases/b")).response.secret();
  RequireTokens(server);

  const auto databases = server.NewStub<v1::DatabaseService>();
  const auto listed = Ask(*databases, &v1::DatabaseService::Stub::ListDatabases,
                          v1::ListDatabasesRequest(), token_b);
  REQUIRE(listed.status.ok());
  REQUIRE(listed.response.databases_size() == 1);
  CHECK(listed.response.databases(0).name() == "databases/b");
  CHECK(listed.response.next_page_token().empty());

  const auto operations = server.NewStub<v1::OperationService>();
  const auto count = [&](const std::string& token) {
    const auto answer = Ask(*operations, &v1::OperationService::Stub::ListOperations,
                            v1::ListOperationsRequest(), token);
    REQUIRE(answer.status.ok());
    return answer.response.operations_size();
  };
  CHECK(count(token_a) == 1);
  CHECK(count(token_b) == 0);
  v1::GetOperationRequest request;
  request.set_name(ingested.operation().name());
  const auto get = [&](const std::string& token) {
    return Ask(*operations, &v1::OperationService::Stub::GetOperation, request, token)
        .status.error_code();
  };
  CHECK(get(token_a) == StatusCode::OK);
  CHECK(get(token_b) == StatusCode::PERMISSION_DENIED);
  // A missing operation gets the same error, so that its existence is not disclosed.
  request.set_name("operations/none");
  CHECK(get(token_b) == StatusCode::PERMISSION_DENIED);
}

}  // namespace
}  // namespace motiondb::tests::access_service_test
