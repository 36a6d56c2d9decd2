#include "server/security/token_registry.h"

#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "absl/strings/escaping.h"

namespace motiondb::tests::token_registry_test {
namespace {

TEST_CASE("Secret: random bytes have the requested size and differ each time", "[security]") {
  std::set<std::string> seen;
  for (int i = 0; i < 100; ++i) {
    const auto random = server::RandomHex(32);
    REQUIRE(random.ok());
    CHECK(random->size() == 64);
    CHECK(seen.insert(*random).second);
  }
}

TEST_CASE("Secret: the hash is SHA-256 of salt and secret", "[security]") {
  // FIPS 180-2, appendix B.1: SHA-256("abc").
  CHECK(absl::BytesToHexString(server::HashSecret("a", "bc")) ==
        "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(server::HashSecret("salt", "x") != server::HashSecret("tlas", "x"));
}

TEST_CASE("Secret: a joined token can be split", "[security]") {
  const std::string text = server::JoinToken("1f", "0a0b");
  CHECK(text == "mdb_1f_0a0b");
  const auto token = server::SplitToken(text);
  REQUIRE(token.has_value());
  CHECK(token->id == "1f");
  CHECK(token->secret == "0a0b");
  for (const char* wrong : {"", "mdb_", "mdb_1f", "mdb_1f_", "mdb__0a", "MDB_1f_0a", "1f_0a"}) {
    INFO(wrong);
    CHECK(!server::SplitToken(wrong).has_value());
  }
}

TEST_CASE("Secret: compares bytes", "[security]") {
  CHECK(server::SameBytes("", ""));
  CHECK(server::SameBytes("abc", "abc"));
  CHECK(!server::SameBytes("abc", "abd"));
  CHECK(!server::SameBytes("abc", "ab"));
}

}  // namespace
}  // namespace motiondb::tests::token_registry_test
