#include "server/security/access_control.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <utility>

#include "absl/strings/match.h"
#include "core/motion/error.h"
#include "server/engine/operator_log.h"
#include "server/engine/work/clock.h"
#include "server/security/token_registry.h"
#include "server/translate/status_mapping.h"

namespace motiondb::server {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kMinute{60'000};
constexpr int kNoChangeEntriesPerMinute = 10;
constexpr char kAdminTokenId[] = "admin-token-file";

// Returns the token in `Bearer {token}`; empty if the header has another form.
std::string BearerOf(const std::string& authorization) {
  constexpr std::string_view kScheme = "bearer ";
  if (!absl::StartsWithIgnoreCase(authorization, kScheme.data())) return "";
  return authorization.substr(kScheme.size());
}

std::shared_ptr<KnownToken> MakeAdminToken(const std::string& secret) {
  storage::TokenRecord record{.id = kAdminTokenId, .role = storage::Role::kAdmin};
  // The salt makes the hash different in each process. An empty salt is acceptable: the hash stays
  // in memory.
  record.salt = RandomHex(16).value_or("");
  record.secret_hash = HashSecret(record.salt, secret);
  return std::make_shared<KnownToken>(std::move(record));
}

}  // namespace

AccessControl::AccessControl(storage::AccessStore& store, const AccessOptions& options)
    : store_(store),
      options_(options),
      admin_token_(options.admin_token.empty() ? nullptr : MakeAdminToken(options.admin_token)),
      tokens_(store),
      failures_(options.failures_per_minute, kMinute),
      no_change_entries_(kNoChangeEntriesPerMinute, kMinute),
      warnings_(1, kMinute) {
  if (!options_.authentication) return;
  const absl::Status read = tokens_.ReadAhead(NowMicroseconds());
  if (!read.ok())
    spdlog::warn("cannot preload tokens; each is read at its first use: error={}", read.ToString());
}

absl::StatusOr<Caller> AccessControl::Authenticate(const PeerCredentials& credentials) {
  if (!options_.authentication) {
    return Caller{.principal = kAnonymous, .role = storage::Role::kAdmin};
  }
  if (!credentials.authorization.empty())
    return ByToken(credentials.authorization, credentials.address);
  if (!credentials.common_name.empty() && options_.certificate_role.has_value()) {
    return Caller{.principal = fmt::format("certificate:{}", credentials.common_name),
                  .role = *options_.certificate_role};
  }
  return Fail(
      "no token", credentials.address,
      core::WithReason(
          "TOKEN_MISSING",
          absl::UnauthenticatedError(
              "a token is needed; set --token-file or MOTIONDB_TOKEN for motiondb, or send the "
              "header `authorization: Bearer {token}`")));
}

absl::StatusOr<Caller> AccessControl::ByToken(const std::string& authorization,
                                              const std::string& address) {
  const std::string bearer = BearerOf(authorization);
  if (bearer.empty()) {
    return Fail("no bearer token", address,
                core::WithReason("TOKEN_INVALID",
                                 absl::UnauthenticatedError(
                                     "expected the header `authorization: Bearer {token}`")));
  }
  std::shared_ptr<const KnownToken> token = FindAdminToken(bearer);
  if (token == nullptr) token = tokens_.FindInMemory(bearer);
  if (token == nullptr) {
    const milliseconds wait = failures_.Wait(AttemptSource(address));
    if (wait.count() > 0) {
      return Fail(
          "too many wrong tokens", address,
          core::WithReason("TOO_MANY_ATTEMPTS",
                           RetryLater(wait, "too many wrong tokens from {}; try again in {:.0f} s",
                                      address, std::chrono::duration<double>(wait).count())));
    }
    MOTIONDB_ASSIGN_OR_RETURN(token, tokens_.Find(bearer));
  }
  if (token == nullptr) {
    failures_.Count(AttemptSource(address));
    return Fail("a wrong token", address,
                core::WithReason("TOKEN_INVALID", absl::UnauthenticatedError(
                                                      "the token is not one of this server's")));
  }
  if (absl::Status valid = token->CheckValid(NowMicroseconds()); !valid.ok()) {
    const std::string what =
        fmt::format("a token that is not valid ({})", std::string(valid.message()));
    return Fail(what, address, std::move(valid));
  }
  const storage::TokenRecord& record = token->record();
  return Caller{fmt::format("tokens/{}", record.id), record.role, record.database, token};
}

std::shared_ptr<const KnownToken> AccessControl::FindAdminToken(const std::string& bearer) const {
  const storage::MutexLock lock(admin_mutex_);
  return admin_token_ != nullptr && admin_token_->HasSecret(bearer) ? admin_token_ : nullptr;
}

bool AccessControl::ReplaceAdminToken(const std::string& token) {
  const storage::MutexLock lock(admin_mutex_);
  if (admin_token_ != nullptr) {
    if (admin_token_->HasSecret(token)) return false;
    admin_token_->End();
  }
  admin_token_ = MakeAdminToken(token);
  return true;
}

bool AccessControl::CanAdministerWithoutToken() const {
  const storage::MutexLock lock(admin_mutex_);
  return !options_.authentication || admin_token_ != nullptr ||
         options_.certificate_role == storage::Role::kAdmin;
}

bool AccessControl::HasAdminAccess(std::int64_t now_us) {
  return CanAdministerWithoutToken() || tokens_.HasAdmin(now_us).value_or(true);
}

absl::StatusOr<storage::TokenRecord> AccessControl::RevokeToken(
    const std::string& id, std::int64_t now_us, const storage::WriteOptions& terms) {
  return tokens_.Revoke(id, now_us, terms,
                        CanAdministerWithoutToken() ? TokenRegistry::LastAdmin::kMayRevoke
                                                    : TokenRegistry::LastAdmin::kKeep);
}

absl::Status AccessControl::Fail(std::string_view what, const std::string& address,
                                 absl::Status status) {
  if (warnings_.Count(fmt::format("{} {}", AttemptSource(address), what))) {
    spdlog::warn("{} from {}", what, address);
  }
  return status;
}

absl::Status AccessControl::Recheck(const Caller& caller) const {
  return caller.token == nullptr ? absl::OkStatus() : caller.token->CheckValid(NowMicroseconds());
}

absl::Status AccessControl::Record(const storage::AuditRecord& record, bool of_administrator,
                                   bool changed, const core::Cancelled& cancelled) {
  if (!changed && !of_administrator &&
      !no_change_entries_.Count(
          fmt::format("{} {}", AttemptSource(record.peer), record.principal))) {
    return absl::OkStatus();
  }
  return StoreAuditRecord(store_, record, cancelled);
}

}  // namespace motiondb::server
