#include "server/security/security_options.h"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/certificates.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests::security_options_test {
namespace {

using server::Authentication;
using server::DeriveSecurityConfig;
using server::SecurityOptions;

constexpr char kLoopback[] = "127.0.0.1:0";
constexpr char kEverywhere[] = "0.0.0.0:0";

struct Files {
  TemporaryDirectory directory;
  Authority authority{directory / "", "authority"};
  KeyPairFiles pair = authority.Issue("server", "localhost");

  SecurityOptions Encrypted() const {
    return {.tls = {.certificate = pair.certificate, .key = pair.key}};
  }
};

std::string Message(const SecurityOptions& options, const char* listen = kLoopback) {
  const auto plan = DeriveSecurityConfig(options, listen);
  return std::string(plan.status().message());
}

TEST_CASE("Security: the most exposed address decides", "[security]") {
  const Files files;
  const SecurityOptions encrypted = files.Encrypted();
  const auto open = DeriveSecurityConfig(encrypted, kLoopback, kLoopback);
  REQUIRE(open.ok());
  CHECK(!open->access.authentication);
  const auto exposed = DeriveSecurityConfig(encrypted, kLoopback, kEverywhere);
  REQUIRE(exposed.ok());
  CHECK(exposed->access.authentication);
  CHECK(DeriveSecurityConfig(encrypted, kEverywhere, kLoopback)->access.authentication);
  CHECK(absl::IsFailedPrecondition(DeriveSecurityConfig({}, kLoopback, kEverywhere).status()));
}

TEST_CASE("Security: loopback addresses", "[security]") {
  for (const char* own : {"127.0.0.1:1", "127.9.9.9:1", "localhost:1", "[::1]:1"}) {
    INFO(own);
    CHECK(server::IsLoopback(own));
  }
  for (const char* open : {"0.0.0.0:1", "[::]:1", "10.0.0.1:1", "localhost.example:1", "robot:1",
                           "128.0.0.1:1", "127.0.0.1.example:1"}) {
    INFO(open);
    CHECK(!server::IsLoopback(open));
  }
}

TEST_CASE("Security: on loopback every caller is accepted unless tokens are required",
          "[security]") {
  const auto plain = DeriveSecurityConfig({}, kLoopback);
  REQUIRE(plain.ok());
  CHECK(!plain->access.authentication);
  CHECK(plain->reflection);
  CHECK(plain->warnings.empty());
  const auto tokens = DeriveSecurityConfig({.authentication = Authentication::kToken}, kLoopback);
  REQUIRE(tokens.ok());
  CHECK(tokens->access.authentication);
  CHECK(!tokens->reflection);
}

TEST_CASE("Security: warns of roles without authentication", "[security]") {
  const Files files;
  SecurityOptions options = files.Encrypted();
  options.tls.client_ca = files.authority.certificate();
  options.certificate_role = storage::Role::kReader;
  const auto none = DeriveSecurityConfig(options, kLoopback);
  REQUIRE(none.ok());
  REQUIRE(none->warnings.size() == 1);
  CHECK_THAT(none->warnings[0],
             Catch::Contains("certificate-role") && Catch::Contains("--authentication token"));
  options.authentication = Authentication::kToken;
  const auto asked = DeriveSecurityConfig(options, kLoopback);
  REQUIRE(asked.ok());
  CHECK(asked->warnings.empty());
}

TEST_CASE("Security: other addresses need TLS and tokens", "[security]") {
  const Files files;
  const absl::Status bare = DeriveSecurityConfig({}, kEverywhere).status();
  CHECK(absl::IsFailedPrecondition(bare));
  CHECK_THAT(std::string(bare.message()),
             Catch::Contains("without TLS;") && Catch::Contains("--insecure"));
  SecurityOptions options = files.Encrypted();
  const auto good = DeriveSecurityConfig(options, kEverywhere);
  REQUIRE(good.ok());
  CHECK(good->access.authentication);
  CHECK(good->warnings.empty());
  options.authentication = Authentication::kNone;
  CHECK_THAT(Message(options, kEverywhere), Catch::Contains("without authentication;"));
  CHECK_THAT(Message({.authentication = Authentication::kNone}, kEverywhere),
             Catch::Contains("without TLS and authentication;"));
}

TEST_CASE("Security: --insecure serves with a warning", "[security]") {
  const Files files;
  const auto bare = DeriveSecurityConfig({.insecure = true}, kEverywhere);
  REQUIRE(bare.ok());
  CHECK(!bare->access.authentication);
  REQUIRE(bare->warnings.size() == 1);
  CHECK_THAT(bare->warnings[0], Catch::StartsWith("INSECURE: 0.0.0.0:0") &&
                                    Catch::Contains("without TLS and authentication"));
  const auto tokens = DeriveSecurityConfig(
      {.authentication = Authentication::kToken, .insecure = true}, kEverywhere);
  REQUIRE(tokens.ok());
  CHECK(tokens->access.authentication);
  REQUIRE(tokens->warnings.size() == 1);
  CHECK_THAT(tokens->warnings[0], Catch::Contains("without TLS."));
  SecurityOptions options = files.Encrypted();
  options.insecure = true;
  const auto encrypted = DeriveSecurityConfig(options, kEverywhere);
  REQUIRE(encrypted.ok());
  CHECK(encrypted->access.authentication);
  CHECK(encrypted->warnings.empty());
}

TEST_CASE("Security: the error names an invalid TLS file", "[security]") {
  const Files files;
  const KeyPairFiles other = files.authority.Issue("other", "other");
  SecurityOptions options = files.Encrypted();
  options.tls.key = other.key;
  CHECK_THAT(Message(options), Catch::StartsWith(other.key + ": is not the key of") &&
                                   Catch::Contains(files.pair.certificate));
  options = files.Encrypted();
  options.tls.certificate = "/nonexistent/server.crt";
  CHECK_THAT(Message(options), Catch::StartsWith("/nonexistent/server.crt: cannot be read"));
  const KeyPairFiles old = files.authority.Issue("old", "localhost", -1);
  options.tls = {.certificate = old.certificate, .key = old.key};
  CHECK_THAT(Message(options), Catch::StartsWith(old.certificate + ": the certificate expired on"));
  options = files.Encrypted();
  std::swap(options.tls.certificate, options.tls.key);
  CHECK_THAT(Message(options), Catch::Contains("server.key: expected a certificate"));
  options = files.Encrypted();
  options.tls.key = files.pair.certificate;
  CHECK_THAT(Message(options), Catch::Contains("server.crt: expected a private key"));
  options = files.Encrypted();
  options.tls.client_ca = files.pair.key;
  CHECK_THAT(Message(options), Catch::Contains("server.key: expected a certificate"));
  options = files.Encrypted();
  std::ofstream(options.tls.certificate).flush();
  CHECK_THAT(Message(options), Catch::EndsWith("server.crt: expected a certificate in PEM"));
  options = files.Encrypted();
  options.tls.key.clear();
  CHECK_THAT(Message(options), Catch::Contains("together"));
  options = {};
  options.tls.client_ca = files.authority.certificate();
  CHECK_THAT(Message(options), Catch::Contains("tls-client-ca needs tls-certificate"));
  CHECK_THAT(Message({.peer_ca = files.authority.certificate()}),
             Catch::Contains("tls-peer-ca needs tls-certificate"));
  CHECK_THAT(Message({.peer_name = "motiondb"}),
             Catch::Contains("tls-peer-name needs tls-certificate"));
  CHECK_THAT(Message({.certificate_role = storage::Role::kReader}),
             Catch::Contains("certificate-role needs tls-client-ca"));
}

TEST_CASE("Security: warns of a key that others can read", "[security]") {
  const Files files;
  for (const auto& [mode, fault] : {std::pair(0644, "can read it"), std::pair(0622, "can write it"),
                                    std::pair(0660, "its group can write it")}) {
    chmod(files.pair.key.c_str(), mode);
    const auto plan = DeriveSecurityConfig(files.Encrypted(), kEverywhere);
    REQUIRE(plan.ok());
    REQUIRE(plan->warnings.size() == 1);
    CHECK_THAT(plan->warnings[0],
               Catch::StartsWith(files.pair.key + ": ") && Catch::Contains(fault));
  }
  for (const mode_t mode : {0400, 0440, 0600, 0640}) {
    chmod(files.pair.key.c_str(), mode);
    CHECK(DeriveSecurityConfig(files.Encrypted(), kEverywhere)->warnings.empty());
  }
}

TEST_CASE("Security: an admin token file that others can read is refused", "[security]") {
  const TemporaryDirectory directory;
  const std::string path = directory / "token";
  std::ofstream(path) << "  a long enough secret of an admin\n";
  chmod(path.c_str(), 0644);
  CHECK_THAT(Message({.admin_token_file = path}), Catch::StartsWith(path + ": everybody"));
  for (const mode_t mode : {0602, 0622, 0642}) {
    chmod(path.c_str(), mode);
    CHECK_THAT(Message({.admin_token_file = path}),
               Catch::StartsWith(path + ": everybody on this machine can write it"));
  }
  for (const mode_t mode : {0620, 0660}) {
    chmod(path.c_str(), mode);
    CHECK_THAT(Message({.admin_token_file = path}),
               Catch::StartsWith(path + ": its group can write it"));
  }
  for (const mode_t mode : {0400, 0440, 0600, 0640}) {
    chmod(path.c_str(), mode);
    const auto plan = DeriveSecurityConfig({.admin_token_file = path}, kLoopback);
    REQUIRE(plan.ok());
    CHECK(plan->access.admin_token == "a long enough secret of an admin");
  }
  std::ofstream(path) << "short";
  CHECK_THAT(Message({.admin_token_file = path}), Catch::Contains("at least 20 characters"));
  CHECK_THAT(Message({.admin_token_file = path + "x"}), Catch::StartsWith(path + "x: "));
  // A text that cannot be in a header cannot be the intended token.
  for (const char* const text :
       {"a long enough secret\nand another line", "a long enough secret \x01",
        "a long enough secr\xc3\xa9t", "\xff\xfe\x80 a long enough secret"}) {
    std::ofstream(path) << text;
    CHECK_THAT(Message({.admin_token_file = path}),
               Catch::StartsWith(path + ": expected a token on one line, of printable ASCII") &&
                   !Catch::Contains("enough"));
  }
  std::ofstream(path).flush();
  CHECK_THAT(Message({.admin_token_file = path}), Catch::Contains("at least 20 characters"));
  std::filesystem::create_directory(path + ".d");
  std::filesystem::permissions(path + ".d", std::filesystem::perms::owner_all);
  CHECK(Message({.admin_token_file = path + ".d"}) == path + ".d: cannot be read: Is a directory");
}

}  // namespace
}  // namespace motiondb::tests::security_options_test
