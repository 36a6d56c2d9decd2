#include "tests/storage/conformance/access_store_conformance.h"

#include <string>

#include "tests/storage/require_ok.h"
#include "tests/storage/samples.h"

namespace motiondb::tests {
namespace {

using absl::StatusCode;
using storage::AuditRecord;
using storage::Role;
using storage::TokenRecord;

TokenRecord SampleToken(const std::string& id) {
  return {.id = id,
          .role = Role::kIngester,
          .database = "walks",
          .description = "the robot in room 7",
          .salt = std::string("salt\0\xff\x80", 7),
          .secret_hash = std::string("\0hash\xfe", 6),
          .create_time_us = 1'700'000'000'000'001,
          .expire_time_us = 1'800'000'000'000'002,
          .revoke_time_us = 0};
}

bool SameRecord(const TokenRecord& a, const TokenRecord& b) {
  return a.id == b.id && a.role == b.role && a.database == b.database &&
         a.description == b.description && a.salt == b.salt && a.secret_hash == b.secret_hash &&
         a.create_time_us == b.create_time_us && a.expire_time_us == b.expire_time_us &&
         a.revoke_time_us == b.revoke_time_us;
}

}  // namespace

void TestTokens(StoreUnderTest& store) {
  const auto access = [&]() -> storage::AccessStore& { return store->access(); };
  REQUIRE(Require(access().ListTokens("", 10)).empty());
  REQUIRE_ERROR(access().GetToken("b"), StatusCode::kNotFound, "'b'");
  REQUIRE_ERROR(access().RevokeToken("b", 5), StatusCode::kNotFound, "'b'");
  REQUIRE_ERROR(access().ListTokens("b", 10), StatusCode::kNotFound, "'b'");

  // Tokens are listed in order of creation.
  for (const char* id : {"b", "c", "a"}) REQUIRE_OK(access().AddToken(SampleToken(id)));
  auto admin = SampleToken("d");
  admin.role = Role::kAdmin;
  admin.database = "";
  admin.description = "";
  admin.expire_time_us = 0;
  REQUIRE_OK(access().AddToken(admin));
  REQUIRE_ERROR(access().AddToken(SampleToken("c")), StatusCode::kAlreadyExists, "'c'");
  REQUIRE(SameRecord(Require(access().GetToken("a")), SampleToken("a")));
  REQUIRE(SameRecord(Require(access().GetToken("d")), admin));

  const auto ids = [&](const std::string& after, int limit) {
    std::string joined;
    for (const auto& record : Require(access().ListTokens(after, limit))) joined += record.id;
    return joined;
  };
  REQUIRE(ids("", 10) == "bcad");
  REQUIRE(ids("", 2) == "bc");
  REQUIRE(ids("c", 10) == "ad");
  REQUIRE(ids("d", 10).empty());

  // The first revocation determines the time.
  REQUIRE(Require(access().RevokeToken("c", 50)).revoke_time_us == 50);
  REQUIRE(Require(access().RevokeToken("c", 60)).revoke_time_us == 50);
  REQUIRE(Require(access().GetToken("c")).revoke_time_us == 50);
  REQUIRE(Require(access().GetToken("a")).revoke_time_us == 0);
  REQUIRE(ids("", 10) == "bcad");
}

void TestAudit(StoreUnderTest& store) {
  const auto access = [&]() -> storage::AccessStore& { return store->access(); };
  REQUIRE(Require(access().ListAuditRecords(0, 10)).empty());
  for (int i = 1; i <= 5; ++i) {
    AuditRecord record{.time_us = 1'700'000'000'000'000 - i,  // clocks can go back
                       .principal = "robot",
                       .peer = "ipv4:10.0.0.7:1234",
                       .method = "/motiondb.v1.ClipService/DeleteClip",
                       .resource = "databases/walks/clips/" + std::to_string(i),
                       .code = i == 3 ? 7 : 0,
                       .request_id = "r-" + std::to_string(i)};
    REQUIRE_OK(access().AddAuditRecord(record));
  }
  const auto newest = Require(access().ListAuditRecords(0, 2));
  REQUIRE(newest.size() == 2);
  REQUIRE(newest[0].request_id == "r-5");
  REQUIRE(newest[1].request_id == "r-4");
  REQUIRE(newest[0].sequence > newest[1].sequence);
  const auto rest = Require(access().ListAuditRecords(newest[1].sequence, 10));
  REQUIRE(rest.size() == 3);
  REQUIRE(rest[0].request_id == "r-3");
  REQUIRE(rest[0].time_us == 1'699'999'999'999'997);
  REQUIRE(rest[0].principal == "robot");
  REQUIRE(rest[0].peer == "ipv4:10.0.0.7:1234");
  REQUIRE(rest[0].method == "/motiondb.v1.ClipService/DeleteClip");
  REQUIRE(rest[0].resource == "databases/walks/clips/3");
  REQUIRE(rest[0].code == 7);
  REQUIRE(rest[1].code == 0);
  REQUIRE(Require(access().ListAuditRecords(rest[2].sequence, 10)).empty());
}

void TestAuditOfChanges(StoreUnderTest& store) {
  const auto newest = [&] {
    const auto records = Require(store->access().ListAuditRecords(0, 1));
    return records.empty() ? "" : records[0].method;
  };
  const auto entry = [](const std::string& method) { return AuditRecord{.method = method}; };
  const AuditRecord create = entry("create"), again = entry("again"), none = entry("none");
  const AuditRecord clip = entry("clip"), token = entry("token"), revoke = entry("revoke");
  const AuditRecord remove = entry("remove");

  REQUIRE_OK(store->CreateDatabase(SampleDatabase("d"), {&create}));
  REQUIRE(newest() == "create");
  REQUIRE_ERROR(store->CreateDatabase(SampleDatabase("d"), {&again}), StatusCode::kAlreadyExists,
                "d");
  REQUIRE_OK(store->AddClip(SampleClip("d", "walk", 1)));
  REQUIRE_ERROR(store->DeleteClip("d", "run", {&none}), StatusCode::kNotFound, "run");
  REQUIRE(newest() == "create");
  REQUIRE_OK(store->DeleteClip("d", "walk", {&clip}));
  REQUIRE(newest() == "clip");
  REQUIRE_OK(store->access().AddToken(SampleToken("a"), {&token}));
  REQUIRE(newest() == "token");
  REQUIRE_ERROR(store->access().AddToken(SampleToken("a"), {&again}), StatusCode::kAlreadyExists,
                "'a'");
  REQUIRE_ERROR(store->access().RevokeToken("b", 5, {&none}), StatusCode::kNotFound, "'b'");
  REQUIRE(newest() == "token");
  REQUIRE(Require(store->access().RevokeToken("a", 5, {&revoke})).revoke_time_us == 5);
  REQUIRE(newest() == "revoke");
  REQUIRE_ERROR(store->DeleteDatabase("e", {&none}), StatusCode::kNotFound, "e");
  REQUIRE(newest() == "revoke");
  REQUIRE_OK(store->DeleteDatabase("d", {&remove}));
  REQUIRE(newest() == "remove");
  REQUIRE(Require(store->access().ListAuditRecords(0, 10)).size() == 5);
}

}  // namespace motiondb::tests
