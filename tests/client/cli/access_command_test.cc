// motiondb token, motiondb audit, and the token of the command line itself.
#include <motiondb/v1/access.pb.h>
#include <motiondb/v1/database.pb.h>

#include <catch2/catch.hpp>

#include "client/cli/server_text.h"
#include "tests/client/fake_server.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/project_paths.h"

namespace motiondb::tests::access_command_test {
namespace {

using Catch::Contains;
using Catch::StartsWith;

v1::Token Reader() {
  v1::Token token;
  token.set_name("tokens/1f");
  token.set_role(v1::ROLE_READER);
  token.set_database("databases/walks");
  token.mutable_create_time()->set_seconds(1'000);
  token.mutable_expire_time()->set_seconds(2'000);
  return token;
}

TEST_CASE("motiondb token create: sends the options; prints only the secret to standard output",
          "[client][cli]") {
  FakeServer server;
  v1::CreateTokenResponse response;
  *response.mutable_token() = Reader();
  response.set_secret("mdb_1f_00");
  server.Answer("CreateToken", response);
  const auto made =
      RunMotiondb(server.address(), {"token", "create", "--role", "reader", "--database", "walks",
                                     "--expires", "30d", "--description", "the robot"});
  CHECK(made.exit_code == 0);
  CHECK(made.out == "mdb_1f_00\n");
  CHECK_THAT(made.err, StartsWith("tokens/1f: reader of databases/walks, until 1970-01-01T00:33"));
  const auto json = RunMotiondb(server.address(), {"token", "create", "--role", "admin", "--json"});
  CHECK_THAT(json.out, Contains("\"secret\":\"mdb_1f_00\""));
  const auto requests = server.Requests<v1::CreateTokenRequest>("CreateToken");
  REQUIRE(requests.size() == 2);
  CHECK(requests[0].token().role() == v1::ROLE_READER);
  CHECK(requests[0].token().database() == "databases/walks");
  CHECK(requests[0].ttl().seconds() == 30 * 86400);
  CHECK(requests[0].token().description() == "the robot");
  CHECK(requests[1].token().role() == v1::ROLE_ADMIN);
  CHECK(!requests[1].has_ttl());
  for (const char* wrong : {"30", "0d", "-1d", "soon", "3y"}) {
    INFO(wrong);
    CHECK(RunMotiondb(server.address(),
                      {"token", "create", "--role", "reader", std::string("--expires=") + wrong})
              .exit_code == 2);
  }
  CHECK_THAT(
      RunMotiondb(server.address(), {"token", "create", "--role", "reader", "--expires", "30"}).err,
      Contains("got 30; did you mean 30d?"));
  CHECK(RunMotiondb(server.address(), {"token", "create"}).exit_code == 2);
  for (const char* wrong : {"king", "3"}) {
    const auto role = RunMotiondb(server.address(), {"token", "create", "--role", wrong});
    CHECK(role.exit_code == 2);
    CHECK_THAT(role.err, Contains(std::string(wrong) + " not in {admin,ingester,reader}"));
  }
}

TEST_CASE("motiondb token list and revoke", "[client][cli]") {
  FakeServer server;
  v1::ListTokensResponse list;
  *list.add_tokens() = Reader();
  server.Answer("ListTokens", list);
  CHECK_THAT(RunMotiondb(server.address(), {"token", "list"}).out,
             StartsWith("TOKEN") && Contains("1f") && Contains("walks") && Contains("expired"));
  CHECK_THAT(RunMotiondb(server.address(), {"token", "list", "--json"}).out,
             StartsWith("{\"name\":\"tokens/1f\""));
  v1::RevokeTokenResponse revoked;
  *revoked.mutable_token() = Reader();
  server.Answer("RevokeToken", revoked);
  CHECK(RunMotiondb(server.address(), {"token", "revoke", "1f"}).out == "revoked tokens/1f\n");
  CHECK(server.Requests<v1::RevokeTokenRequest>("RevokeToken")[0].name() == "tokens/1f");
}

TEST_CASE("motiondb token revoke: sends only the id of a complete token", "[client][cli]") {
  FakeServer server;
  v1::RevokeTokenResponse revoked;
  *revoked.mutable_token() = Reader();
  for (const char* given : {"mdb_1f_00ff", "tokens/mdb_1f_00ff", "mdb_1f", "tokens/1f"}) {
    server.Answer("RevokeToken", revoked);
    CHECK(RunMotiondb(server.address(), {"token", "revoke", given}).exit_code == 0);
    CHECK(server.Requests<v1::RevokeTokenRequest>("RevokeToken").back().name() == "tokens/1f");
  }
}

std::string TokensTextAt(const std::vector<v1::Token>& tokens, std::int64_t now_seconds) {
  return client::WithStyles(client::TokensTable(tokens, now_seconds).ToString(), false);
}

TEST_CASE("TokensTable: states of tokens", "[client]") {
  v1::Token revoked = Reader();
  revoked.mutable_revoke_time()->set_seconds(1'500);
  v1::Token forever = Reader();
  forever.clear_expire_time();
  CHECK_THAT(TokensTextAt({Reader()}, 1'999), Contains(" valid "));
  CHECK_THAT(TokensTextAt({Reader()}, 2'000), Contains(" expired "));
  CHECK_THAT(TokensTextAt({revoked}, 1'999), Contains(" revoked "));
  CHECK_THAT(TokensTextAt({forever}, 9'999), Contains(" valid ") && Contains("never"));
}

TEST_CASE("motiondb audit: reads pages up to the requested number", "[client][cli]") {
  FakeServer server;
  v1::ListAuditEntriesResponse first, second;
  auto* entry = first.add_entries();
  entry->set_principal("tokens/1f");
  entry->set_method("DatabaseService.DeleteDatabase");
  entry->set_resource("databases/walks");
  entry->set_code(7);
  first.set_next_page_token("more");
  second.add_entries()->set_principal("anonymous");
  server.Answer("ListAuditEntries", first);
  server.Answer("ListAuditEntries", second);
  const auto text = RunMotiondb(server.address(), {"audit", "--count", "2"});
  CHECK_THAT(text.out, StartsWith("TIME") && Contains("tokens/1f") &&
                           Contains("PERMISSION_DENIED") && Contains("anonymous"));
  const auto requests = server.Requests<v1::ListAuditEntriesRequest>("ListAuditEntries");
  REQUIRE(requests.size() == 2);
  CHECK(requests[0].page_size() == 2);
  CHECK(requests[1].page_size() == 1);
  CHECK(requests[1].page_token() == "more");
}

TEST_CASE("motiondb: reads its token from a file or a variable, never from a flag",
          "[client][cli]") {
  FakeServer server;
  server.Answer("ListDatabases", v1::ListDatabasesResponse());
  const TemporaryFolder folder;
  const std::string file = folder.Write("token", "from-a-file\n").string();
  const auto run = [&](std::vector<std::string> command) {
    command.insert(command.end(),
                   {"MOTIONDB_SERVER=" + server.address(), MotiondbProgram(), "list"});
    return RunProgram(command);
  };
  CHECK(run({"env", "MOTIONDB_TOKEN=from-a-variable"}).exit_code == 0);
  CHECK(run({"env", "MOTIONDB_TOKEN_FILE=" + file}).exit_code == 0);
  CHECK(RunMotiondb(server.address(), {"list", "--token-file", file}).exit_code == 0);
  const auto headers = server.HeadersOf("ListDatabases");
  REQUIRE(headers.size() == 3);
  CHECK(headers[0].at("authorization") == "Bearer from-a-variable");
  CHECK(headers[1].at("authorization") == "Bearer from-a-file");
  CHECK(headers[2].at("authorization") == "Bearer from-a-file");
  CHECK_THAT(RunMotiondb(server.address(), {"list", "--token-file", file + "x"}).err,
             Contains("tokenx: no such file"));
  CHECK_THAT(
      RunMotiondb(server.address(), {"list", "--token-file", folder.Write("empty", "").string()})
          .err,
      Contains("the file is empty"));
  CHECK(RunMotiondb(server.address(), {"list", "--token", "x"}).exit_code == 2);
}

}  // namespace
}  // namespace motiondb::tests::access_command_test
