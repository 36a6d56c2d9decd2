#include "server/security/access_control.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "server/engine/work/clock.h"
#include "server/security/token_registry.h"
#include "server/translate/status_mapping.h"
#include "tests/storage/conformance/in_memory_access_store.h"
#include "tests/support/captured_log.h"

namespace motiondb::tests::access_control_test {
namespace {

using server::AccessControl;
using server::AccessOptions;
using server::NowMicroseconds;
using server::PeerCredentials;
using storage::Role;

constexpr std::int64_t kHour = std::int64_t{3600} * 1'000'000;

PeerCredentials Bearer(const std::string& token, const std::string& address = "10.0.0.1") {
  return {"Bearer " + token, "", address};
}

struct Access {
  explicit Access(AccessOptions options = {.authentication = true}) : control(store, options) {
    spdlog::set_level(spdlog::level::off);
  }
  server::CreatedToken Make(Role role, const std::string& database = "", std::int64_t life_us = 0) {
    const std::int64_t now = NowMicroseconds();
    auto made = control.tokens().Make(role, database, "", now, life_us == 0 ? 0 : now + life_us);
    REQUIRE(made.ok());
    return *std::move(made);
  }
  absl::StatusCode CodeOf(const PeerCredentials& credentials) {
    return control.Authenticate(credentials).status().code();
  }

  InMemoryAccessStore store;
  AccessControl control;
};

TEST_CASE("Access: a token is identified by its secret, which is not stored", "[security]") {
  Access access;
  const auto made = access.Make(Role::kIngester, "walks", kHour);
  const auto token = server::SplitToken(made.secret);
  REQUIRE(token.has_value());
  CHECK(token->secret.size() == 64);
  const auto stored = access.store.GetToken(made.record.id);
  REQUIRE(stored.ok());
  const std::string bytes = stored->id + stored->salt + stored->secret_hash + stored->description;
  CHECK(bytes.find(std::string(token->secret)) == std::string::npos);
  CHECK(stored->secret_hash.size() == 32);
  for (int i = 0; i < 2; ++i) {  // from the store, then from memory
    const auto caller = access.control.Authenticate(Bearer(made.secret));
    REQUIRE(caller.ok());
    CHECK(caller->principal == "tokens/" + made.record.id);
    CHECK(caller->role == Role::kIngester);
    CHECK(caller->database == "walks");
  }
}

TEST_CASE("Access: an invalid token is UNAUTHENTICATED", "[security]") {
  Access access;
  const auto made = access.Make(Role::kAdmin);
  std::string other = made.secret;
  other.back() = other.back() == '0' ? '1' : '0';
  const auto unauthenticated = absl::StatusCode::kUnauthenticated;
  CHECK(access.CodeOf({"", "", "10.0.0.1"}) == unauthenticated);
  CHECK(access.CodeOf({made.secret, "", "10.0.0.1"}) == unauthenticated);  // not "Bearer ..."
  CHECK(access.CodeOf(Bearer("")) == unauthenticated);
  CHECK(access.CodeOf(Bearer(other)) == unauthenticated);
  CHECK(access.CodeOf(Bearer("mdb_none_" + std::string(64, '0'))) == unauthenticated);
  CHECK(access.CodeOf(Bearer(made.secret + "0")) == unauthenticated);
  CHECK(access.CodeOf(Bearer(made.secret)) == absl::StatusCode::kOk);
  CHECK(access.CodeOf({"bearer " + made.secret, "", "10.0.0.1"}) == absl::StatusCode::kOk);
  CHECK(access.CodeOf(Bearer(other)) == unauthenticated);
}

TEST_CASE("Access: a token is invalid when it has expired or is revoked", "[security]") {
  Access access;
  const auto past = access.Make(Role::kReader, "", 1);
  CHECK(access.CodeOf(Bearer(past.secret)) == absl::StatusCode::kUnauthenticated);

  const auto made = access.Make(Role::kReader);
  const auto caller = access.control.Authenticate(Bearer(made.secret));
  REQUIRE(caller.ok());
  CHECK(access.control.Recheck(*caller).ok());
  REQUIRE(access.control.tokens().Revoke(made.record.id, NowMicroseconds()).ok());
  CHECK(absl::IsUnauthenticated(access.control.Recheck(*caller)));
  CHECK(access.CodeOf(Bearer(made.secret)) == absl::StatusCode::kUnauthenticated);
  // Another process with the same store reads the revocation.
  AccessControl second(access.store, {.authentication = true});
  CHECK(absl::IsUnauthenticated(second.Authenticate(Bearer(made.secret)).status()));
  CHECK(absl::IsNotFound(access.control.tokens().Revoke("none", 1).status()));
}

// A store that blocks a revocation until the test decides its result.
class SlowStore final : public InMemoryAccessStore {
 public:
  absl::StatusOr<storage::TokenRecord> RevokeToken(
      const std::string& id, std::int64_t time_us,
      const storage::WriteOptions& work_options) override {
    called.set_value();
    const absl::Status outcome = result.get_future().get();
    if (!outcome.ok()) return outcome;
    return InMemoryAccessStore::RevokeToken(id, time_us, work_options);
  }

  std::promise<void> called;
  std::promise<absl::Status> result;
};

TEST_CASE("Access: a revocation on a slow disk is effective immediately and delays no other call",
          "[security]") {
  spdlog::set_level(spdlog::level::off);
  const absl::Status outcome =
      GENERATE(absl::OkStatus(), absl::ResourceExhaustedError("the disk is full"));
  SlowStore store;
  AccessControl control(store, {.authentication = true});
  const auto make = [&] { return *control.tokens().Make(Role::kReader, "", "", 1, 0); };
  const auto stolen = make();
  const auto other = make();
  absl::Status revoked;
  std::thread revoking(
      [&] { revoked = control.tokens().Revoke(stolen.record.id, NowMicroseconds()).status(); });
  store.called.get_future().wait();
  CHECK(absl::IsUnauthenticated(control.Authenticate(Bearer(stolen.secret)).status()));
  CHECK(control.Authenticate(Bearer(other.secret)).ok());
  CHECK(absl::IsUnauthenticated(control.Authenticate(Bearer("mdb_none_none")).status()));
  const auto made_meanwhile = make();
  CHECK(control.Authenticate(Bearer(made_meanwhile.secret)).ok());
  store.result.set_value(outcome);
  revoking.join();
  CHECK(revoked == outcome);
  // If it could not be stored, the token stays valid.
  CHECK(control.Authenticate(Bearer(stolen.secret)).ok() == !outcome.ok());
}

bool IsLastAdmin(const absl::Status& revoked) {
  return absl::IsFailedPrecondition(revoked) &&
         revoked.message().find("the last admin token") != std::string::npos;
}

TEST_CASE("Access: the last admin token cannot be revoked", "[security]") {
  Access access;
  const auto revoke = [&](const server::CreatedToken& token) {
    return access.control.RevokeToken(token.record.id, NowMicroseconds()).status();
  };
  const auto last = access.Make(Role::kAdmin);
  // None of these can create a token.
  const auto of_database = access.Make(Role::kAdmin, "walks");
  const auto expired = access.Make(Role::kAdmin, "", 1);
  const auto former = access.Make(Role::kAdmin);
  const auto reader = access.Make(Role::kReader);
  CHECK(revoke(former).ok());
  CHECK(IsLastAdmin(revoke(last)));
  CHECK(access.CodeOf(Bearer(last.secret)) == absl::StatusCode::kOk);
  CHECK(access.store.GetToken(last.record.id)->revoke_time_us == 0);
  for (const auto* token : {&of_database, &expired, &former, &reader}) CHECK(revoke(*token).ok());
  CHECK(absl::IsNotFound(access.control.RevokeToken("none", 1).status()));
  const auto next = access.Make(Role::kAdmin, "", kHour);
  CHECK(revoke(last).ok());
  CHECK(IsLastAdmin(revoke(next)));
}

TEST_CASE("Access: the last admin token can be revoked if administration needs no token",
          "[security]") {
  const auto revoke_only = [](const AccessOptions& options) {
    Access access(options);
    return access.control.RevokeToken(access.Make(Role::kAdmin).record.id, NowMicroseconds())
        .status();
  };
  CHECK(IsLastAdmin(revoke_only({.authentication = true})));
  CHECK(IsLastAdmin(revoke_only({.authentication = true, .certificate_role = Role::kIngester})));
  CHECK(revoke_only({}).ok());
  CHECK(revoke_only({.authentication = true, .admin_token = "the administrator's own"}).ok());
  CHECK(revoke_only({.authentication = true, .certificate_role = Role::kAdmin}).ok());
}

TEST_CASE("Access: if admins revoke each other concurrently, one remains", "[security]") {
  for (int round = 0; round < 50; ++round) {
    Access access;
    std::vector<std::string> ids;
    for (int i = 0; i < 4; ++i) ids.push_back(access.Make(Role::kAdmin).record.id);
    std::vector<absl::Status> revoked(ids.size());
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      threads.emplace_back(
          [&, i] { revoked[i] = access.control.RevokeToken(ids[i], NowMicroseconds()).status(); });
    }
    for (std::thread& thread : threads) thread.join();
    CHECK(std::ranges::count_if(revoked, IsLastAdmin) == 1);
    CHECK(std::ranges::count_if(revoked, [](const auto& status) { return status.ok(); }) == 3);
  }
}

TEST_CASE("Access: too many failures get a retry time; others are not locked out", "[security]") {
  Access access({.authentication = true, .failures_per_minute = 3});
  const auto used = access.Make(Role::kReader);
  // In the store but not in memory, as after a restore.
  const auto unused =
      server::TokenRegistry(access.store).Make(Role::kReader, "", "", NowMicroseconds(), 0);
  REQUIRE(unused.ok());
  CHECK(access.CodeOf(Bearer(used.secret)) == absl::StatusCode::kOk);
  const std::string wrong = "mdb_none_" + std::string(64, '0');
  for (int i = 0; i < 3; ++i) {
    CHECK(access.CodeOf(Bearer(wrong)) == absl::StatusCode::kUnauthenticated);
  }
  const absl::Status refused = access.control.Authenticate(Bearer(wrong)).status();
  CHECK(absl::IsResourceExhausted(refused));
  CHECK(refused.GetPayload(server::kRetryInfoUrl).has_value());
  CHECK(access.CodeOf(Bearer(unused->secret)) == absl::StatusCode::kResourceExhausted);
  CHECK(access.CodeOf(Bearer(used.secret)) == absl::StatusCode::kOk);
  CHECK(access.CodeOf(Bearer(unused->secret, "10.0.0.2")) == absl::StatusCode::kOk);
  // A call without a token does not count as a failed attempt.
  CHECK(access.CodeOf({"", "", "10.0.0.1"}) == absl::StatusCode::kUnauthenticated);
}

TEST_CASE("Access: each kind of failure is logged with its address, once a minute", "[security]") {
  Access access({.authentication = true, .failures_per_minute = 1});
  const auto expired = access.Make(Role::kReader, "", 1);
  const auto revoked = access.Make(Role::kReader);
  REQUIRE(access.control.tokens().Revoke(revoked.record.id, NowMicroseconds()).ok());
  const std::string wrong = "mdb_none_" + std::string(64, '0');
  const CapturedLog log(spdlog::level::debug);
  for (const std::string address : {"10.0.0.1", "10.0.0.2"}) {
    for (int i = 0; i < 5; ++i) {
      access.CodeOf({"", "", address});
      access.CodeOf(Bearer(expired.secret, address));
      access.CodeOf(Bearer(revoked.secret, address));
      access.CodeOf(Bearer(wrong, address));  // first checked, then refused
    }
  }
  const std::string text = log.text();
  INFO(text);
  CHECK(std::ranges::count(text, '\n') == 10);
  for (const std::string& what :
       {std::string("no token"), std::string("a wrong token"), std::string("too many wrong tokens"),
        "a token that is not valid (tokens/" + expired.record.id + " has expired)",
        "a token that is not valid (tokens/" + revoked.record.id + " was revoked)"}) {
    for (const char* address : {"10.0.0.1", "10.0.0.2"}) {
      CHECK(text.find("\"" + what + " from " + address + "\"") != std::string::npos);
    }
  }
  CHECK(text.find(std::string(64, '0')) == std::string::npos);
  for (const auto* token : {&expired, &revoked}) {
    CHECK(text.find(std::string(server::SplitToken(token->secret)->secret)) == std::string::npos);
  }
}

TEST_CASE("Access: wrong tokens do not lock out an unused token, also after a restart",
          "[security]") {
  Access access({.authentication = true, .failures_per_minute = 1});
  const std::string wrong = "mdb_none_" + std::string(64, '0');
  const auto before = access.Make(Role::kReader);
  const auto ended = access.Make(Role::kReader, "", 1);
  const auto revoked = access.Make(Role::kReader);
  REQUIRE(access.control.tokens().Revoke(revoked.record.id, NowMicroseconds()).ok());
  CHECK(access.CodeOf(Bearer(wrong)) == absl::StatusCode::kUnauthenticated);
  CHECK(access.CodeOf(Bearer(wrong)) == absl::StatusCode::kResourceExhausted);
  CHECK(access.CodeOf(Bearer(before.secret)) == absl::StatusCode::kOk);
  const auto during = access.Make(Role::kReader);
  CHECK(access.CodeOf(Bearer(during.secret)) == absl::StatusCode::kOk);

  AccessControl next(access.store, {.authentication = true, .failures_per_minute = 1});
  CHECK(absl::IsUnauthenticated(next.Authenticate(Bearer(wrong)).status()));
  CHECK(absl::IsResourceExhausted(next.Authenticate(Bearer(wrong)).status()));
  CHECK(next.Authenticate(Bearer(before.secret)).ok());
  CHECK(next.Authenticate(Bearer(during.secret)).ok());
  for (const auto* token : {&ended, &revoked}) {
    CHECK(absl::IsResourceExhausted(next.Authenticate(Bearer(token->secret)).status()));
  }
}

TEST_CASE("Access: more tokens than one page are loaded; expired ones are removed", "[security]") {
  InMemoryAccessStore store;
  server::TokenRegistry registry(store);
  std::vector<std::string> secrets;
  for (int i = 0; i < 2100; ++i) {
    const std::int64_t expire_time_us = i % 2 == 0 ? 0 : 20;
    const auto made = registry.Make(Role::kReader, "", "", 10, expire_time_us);
    REQUIRE(made.ok());
    secrets.push_back(made->secret);
  }
  server::TokenRegistry next(store);
  REQUIRE(next.ReadAhead(30).ok());
  for (std::size_t i = 0; i < secrets.size(); ++i) {
    INFO(i);
    CHECK((next.FindInMemory(secrets[i]) != nullptr) == (i % 2 == 0));
  }
  // The first registry adds a token after they expired, which removes them.
  REQUIRE(registry.Make(Role::kReader, "", "", 30, 0).ok());
  while (registry.FindInMemory(secrets[1]) != nullptr) {
    REQUIRE(registry.Make(Role::kReader, "", "", 30, 0).ok());
    REQUIRE(store.ListTokens("", 10'000)->size() < 5000);
  }
  CHECK(registry.FindInMemory(secrets[0]) != nullptr);
}

TEST_CASE("Access: the admin token of a file is valid", "[security]") {
  Access access({.authentication = true, .admin_token = "correct horse battery staple"});
  const auto caller = access.control.Authenticate(Bearer("correct horse battery staple"));
  REQUIRE(caller.ok());
  CHECK(caller->role == Role::kAdmin);
  CHECK(caller->principal == "tokens/admin-token-file");
  CHECK(access.CodeOf(Bearer("correct horse battery stapl")) == absl::StatusCode::kUnauthenticated);
}

TEST_CASE("Access: a new admin token replaces the former one", "[security]") {
  Access access({.authentication = true, .admin_token = "correct horse battery staple"});
  const auto before = access.control.Authenticate(Bearer("correct horse battery staple"));
  REQUIRE(before.ok());
  CHECK(!access.control.ReplaceAdminToken("correct horse battery staple"));
  CHECK(access.control.Recheck(*before).ok());

  CHECK(access.control.ReplaceAdminToken("another horse, another staple"));
  CHECK(absl::IsUnauthenticated(access.control.Recheck(*before)));
  CHECK(access.CodeOf(Bearer("correct horse battery staple")) ==
        absl::StatusCode::kUnauthenticated);
  const auto after = access.control.Authenticate(Bearer("another horse, another staple"));
  REQUIRE(after.ok());
  CHECK(after->principal == before->principal);
  CHECK(after->role == Role::kAdmin);
  CHECK(access.control.Recheck(*after).ok());
}

TEST_CASE("Access: a certificate without a token has the configured role, or none", "[security]") {
  const PeerCredentials certificate{"", "robot-7", "10.0.0.1"};
  CHECK(Access().CodeOf(certificate) == absl::StatusCode::kUnauthenticated);
  Access access({.authentication = true, .certificate_role = Role::kReader});
  const auto caller = access.control.Authenticate(certificate);
  REQUIRE(caller.ok());
  CHECK(caller->principal == "certificate:robot-7");
  CHECK(caller->role == Role::kReader);
  // A token has priority over the certificate.
  const auto made = access.Make(Role::kAdmin);
  const auto both = access.control.Authenticate({"Bearer " + made.secret, "robot-7", "10.0.0.1"});
  REQUIRE(both.ok());
  CHECK(both->role == Role::kAdmin);
  CHECK(access.CodeOf({"Bearer x", "robot-7", "10.0.0.1"}) == absl::StatusCode::kUnauthenticated);
}

TEST_CASE("Access: without authentication every caller is an anonymous admin", "[security]") {
  Access access({.authentication = false});
  const auto caller = access.control.Authenticate(Bearer("nonsense"));
  REQUIRE(caller.ok());
  CHECK(caller->principal == "anonymous");
  CHECK(caller->role == Role::kAdmin);
}

TEST_CASE("Access: calls without effect cannot fill the audit log", "[security]") {
  Access access;
  const auto record = [&](const std::string& principal, int code, bool administers, bool changed) {
    const storage::AuditRecord entry{.principal = principal, .peer = "10.0.0.1", .code = code};
    CHECK(access.control.Record(entry, administers, changed).ok());
  };
  const auto without_effect = [&](const std::string& principal, int code,
                                  bool administers = false) {
    for (int i = 0; i < 100; ++i) record(principal, code, administers, false);
  };
  without_effect("tokens/a", 7);
  without_effect("anonymous", 8);  // too many wrong tokens
  without_effect("tokens/b", 5);   // changes of missing resources
  without_effect("tokens/d", 0);   // no change
  record("tokens/a", 0, false, true);
  without_effect("tokens/c", 1, true);  // backups that an admin cancelled
  record("tokens/a", 0, false, true);
  const auto records = access.store.ListAuditRecords(0, 1000);
  REQUIRE(records.ok());
  CHECK(records->size() == 142);
  CHECK(records->front().code == 0);
}

}  // namespace
}  // namespace motiondb::tests::access_control_test
