#include "server/translate/access_message.h"

#include <catch2/catch.hpp>

#include "motiondb/v1/access.pb.h"

namespace motiondb::tests::access_message_test {
namespace {

constexpr std::int64_t kNow_us = 1'700'000'000'000'000;

TEST_CASE("NewTokenSpec: is read from a request", "[server]") {
  v1::CreateTokenRequest request;
  request.mutable_token()->set_role(v1::ROLE_ADMIN);
  request.mutable_token()->set_database("databases/walks");
  request.mutable_token()->set_description("for tests");
  request.mutable_ttl()->set_seconds(2);
  request.mutable_ttl()->set_nanos(500'000'000);
  const auto wanted = server::ParseCreateToken(request, kNow_us);
  REQUIRE(wanted.ok());
  CHECK(wanted->role == storage::Role::kAdmin);
  CHECK(wanted->database == "walks");
  CHECK(wanted->description == "for tests");
  CHECK(wanted->expire_time_us == kNow_us + 2'500'000);
  request.clear_ttl();
  CHECK(server::ParseCreateToken(request, kNow_us)->expire_time_us == 0);
  request.mutable_ttl()->set_nanos(1'000'000'000);
  CHECK(absl::IsInvalidArgument(server::ParseCreateToken(request, kNow_us).status()));
  request.clear_ttl();
  for (const std::string& text :
       {std::string("\x1b[31mred"), std::string("two\nlines"), std::string(201, 'x')}) {
    request.mutable_token()->set_description(text);
    CHECK(absl::IsInvalidArgument(server::ParseCreateToken(request, kNow_us).status()));
  }
  request.mutable_token()->clear_description();
  REQUIRE(server::ParseCreateToken(request, kNow_us).ok());
  request.mutable_token()->set_role(static_cast<v1::Role>(9));
  CHECK(absl::IsInvalidArgument(server::ParseCreateToken(request, kNow_us).status()));
}

TEST_CASE("NewTokenSpec: a token expires at the requested time", "[server]") {
  v1::CreateTokenRequest request;
  request.mutable_token()->set_role(v1::ROLE_READER);
  request.mutable_token()->mutable_expire_time()->set_seconds(kNow_us / 1'000'000 + 60);
  CHECK(server::ParseCreateToken(request, kNow_us)->expire_time_us == kNow_us + 60'000'000);
  request.mutable_ttl()->set_seconds(2);
  CHECK(absl::IsInvalidArgument(server::ParseCreateToken(request, kNow_us).status()));
  request.clear_ttl();
  const std::int64_t century = std::int64_t{101} * 366 * 24 * 3600;
  for (const std::int64_t seconds : {std::int64_t{-1}, std::int64_t{0}, century}) {
    request.mutable_token()->mutable_expire_time()->set_seconds(kNow_us / 1'000'000 + seconds);
    CHECK(absl::IsInvalidArgument(server::ParseCreateToken(request, kNow_us).status()));
  }
}

TEST_CASE("AuditEntry: texts of a refused caller have no control characters", "[server]") {
  storage::AuditRecord record;
  record.principal = "certificate:evil\nsecond line";
  record.resource =
      "databases/x\r\x1b[31m\x7f \xc2\x9b"
      "2J \xc3\x9f \xff";
  v1::AuditEntry message;
  server::SetAuditEntry(record, message);
  CHECK(message.principal() == "certificate:evil\uFFFDsecond line");
  CHECK(message.resource() == "databases/x\uFFFD\uFFFD[31m\uFFFD \uFFFD2J \u00DF \uFFFD");
}

TEST_CASE("Token: hash and salt are not in the message", "[server]") {
  v1::Token message;
  server::SetToken({.id = "1f",
                    .role = storage::Role::kReader,
                    .description = "d",
                    .salt = "the-salt",
                    .secret_hash = "the-hash",
                    .create_time_us = 1'500'000},
                   message);
  CHECK(message.name() == "tokens/1f");
  CHECK(message.role() == v1::ROLE_READER);
  CHECK(message.database().empty());
  CHECK(message.create_time().seconds() == 1);
  CHECK(!message.has_expire_time());
  CHECK(!message.has_revoke_time());
  CHECK(message.SerializeAsString().find("the-") == std::string::npos);
}

}  // namespace
}  // namespace motiondb::tests::access_message_test
