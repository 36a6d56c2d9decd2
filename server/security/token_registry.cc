#include "server/security/token_registry.h"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/rand.h>
#include <openssl/sha.h>

#include <algorithm>
#include <utility>

#include "absl/strings/escaping.h"
#include "core/motion/error.h"
#include "server/engine/work/clock.h"
#include "text/display_text.h"

namespace motiondb::server {

absl::StatusOr<std::string> RandomHex(int bytes) {
  std::string random(static_cast<std::size_t>(bytes), '\0');
  if (RAND_bytes(reinterpret_cast<unsigned char*>(random.data()), bytes) != 1) {
    return absl::InternalError("the random generator of OpenSSL failed");
  }
  return absl::BytesToHexString(random);
}

std::string HashSecret(std::string_view salt, std::string_view secret) {
  const std::string salted = fmt::format("{}{}", salt, secret);
  std::string hash(SHA256_DIGEST_LENGTH, '\0');
  SHA256(reinterpret_cast<const unsigned char*>(salted.data()), salted.size(),
         reinterpret_cast<unsigned char*>(hash.data()));
  return hash;
}

bool SameBytes(std::string_view a, std::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

std::optional<BearerToken> SplitToken(std::string_view text) {
  if (!text.starts_with(text::kTokenPrefix)) return std::nullopt;
  text.remove_prefix(text::kTokenPrefix.size());
  const std::size_t end = text.find('_');
  if (end == 0 || end == std::string_view::npos || end + 1 == text.size()) return std::nullopt;
  return BearerToken{text.substr(0, end), text.substr(end + 1)};
}

std::string JoinToken(std::string_view id, std::string_view secret) {
  return fmt::format("{}{}_{}", text::kTokenPrefix, id, secret);
}

namespace {

constexpr int kSaltBytes = 16;
constexpr int kSecretBytes = 32;
constexpr std::size_t kMaxReadAhead = 100'000;  // some hundred bytes each
constexpr int kPageSize = 1000;

// Returns whether the token is valid and has the role admin for all databases.
bool Administers(const storage::TokenRecord& token, std::int64_t now_us) {
  return token.role == storage::Role::kAdmin && token.database.empty() &&
         KnownToken(token).CheckValid(now_us).ok();
}

}  // namespace

bool KnownToken::HasSecret(std::string_view secret) const {
  return SameBytes(HashSecret(record_.salt, secret), record_.secret_hash);
}

absl::Status KnownToken::CheckValid(std::int64_t now_us) const {
  if (state_ != State::kValid) {
    return core::WithReason("TOKEN_REVOKED", absl::UnauthenticatedError(
                                                 fmt::format("tokens/{} was revoked", record_.id)));
  }
  if (HasExpired(now_us)) {
    return core::WithReason("TOKEN_EXPIRED", absl::UnauthenticatedError(
                                                 fmt::format("tokens/{} has expired", record_.id)));
  }
  return absl::OkStatus();
}

bool KnownToken::HasEnded(std::int64_t now_us) const {
  return state_ == State::kEnded || HasExpired(now_us);
}

absl::Status TokenRegistry::ReadAhead(std::int64_t now_us) {
  const storage::MutexLock lock(mutex_);
  std::string after;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(auto page, store_.ListTokens(after, kPageSize));
    if (page.empty()) return absl::OkStatus();
    after = page.back().id;
    for (storage::TokenRecord& record : page) {
      if (known_.size() >= kMaxReadAhead) return absl::OkStatus();
      if (KnownToken(record).CheckValid(now_us).ok()) Keep(std::move(record), now_us);
    }
  }
}

absl::StatusOr<CreatedToken> TokenRegistry::Make(storage::Role role, const std::string& database,
                                                 const std::string& description,
                                                 std::int64_t now_us, std::int64_t expire_time_us,
                                                 const MakeAudit& audit,
                                                 const core::Cancelled& cancelled) {
  CreatedToken made;
  storage::TokenRecord& record = made.record;
  MOTIONDB_ASSIGN_OR_RETURN(record.id, RandomHex(text::kTokenIdBytes));
  MOTIONDB_ASSIGN_OR_RETURN(record.salt, RandomHex(kSaltBytes));
  MOTIONDB_ASSIGN_OR_RETURN(const std::string secret, RandomHex(kSecretBytes));
  record.secret_hash = HashSecret(record.salt, secret);
  record.role = role;
  record.database = database;
  record.description = description;
  record.create_time_us = now_us;
  record.expire_time_us = expire_time_us;
  const std::int64_t revocations_before = revocations();
  std::optional<storage::AuditRecord> entry;
  if (audit) entry = audit(record);
  MOTIONDB_RETURN_IF_ERROR(store_.AddToken(record, {entry ? &*entry : nullptr, cancelled}));
  made.secret = JoinToken(record.id, secret);
  const storage::MutexLock lock(mutex_);
  if (revocations_ == revocations_before) Keep(record, now_us);
  return made;
}

absl::StatusOr<bool> TokenRegistry::HasAdminBeside(const std::string& id, std::int64_t now_us) {
  std::string after;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const auto page, store_.ListTokens(after, kPageSize));
    if (page.empty()) return false;
    for (const storage::TokenRecord& other : page) {
      if (other.id != id && Administers(other, now_us)) return true;
    }
    after = page.back().id;
  }
}

absl::Status TokenRegistry::CheckIsNotLastAdmin(const std::string& id, std::int64_t now_us) {
  MOTIONDB_ASSIGN_OR_RETURN(const storage::TokenRecord token, store_.GetToken(id));
  if (!Administers(token, now_us)) return absl::OkStatus();
  MOTIONDB_ASSIGN_OR_RETURN(const bool other, HasAdminBeside(id, now_us));
  if (other) return absl::OkStatus();
  return core::FailedPrecondition(
      "tokens/{} is the last admin token; first create another with `motiondb token create --role "
      "admin`, or start the server with admin-token-file",
      id);
}

absl::StatusOr<storage::TokenRecord> TokenRegistry::Revoke(const std::string& id,
                                                           std::int64_t now_us,
                                                           const storage::WriteOptions& terms,
                                                           LastAdmin last_admin) {
  storage::CancellableMutex::Holder revoking;
  if (last_admin == LastAdmin::kKeep) {
    MOTIONDB_ASSIGN_OR_RETURN(revoking, revoking_mutex_.Lock(terms.cancelled));
    MOTIONDB_RETURN_IF_ERROR(CheckIsNotLastAdmin(id, now_us));
  }
  std::shared_ptr<KnownToken> suspended;
  {
    const storage::MutexLock lock(mutex_);
    const auto found = known_.find(id);
    if (found != known_.end() && found->second->Suspend()) suspended = found->second;
  }
  auto record = store_.RevokeToken(id, now_us, terms);
  const storage::MutexLock lock(mutex_);
  if (!record.ok()) {
    if (suspended != nullptr) suspended->Resume();
    return record;
  }
  ++revocations_;
  if (const auto found = known_.find(id); found != known_.end()) found->second->End();
  return record;
}

absl::Status TokenRegistry::FollowRevocations() {
  std::string after;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const auto page, store_.ListTokens(after, kPageSize));
    if (page.empty()) return absl::OkStatus();
    after = page.back().id;
    const storage::MutexLock lock(mutex_);
    for (const storage::TokenRecord& record : page) {
      if (record.revoke_time_us == 0) continue;
      if (const auto found = known_.find(record.id); found != known_.end()) found->second->End();
    }
  }
}

std::int64_t TokenRegistry::revocations() const {
  const storage::MutexLock lock(mutex_);
  return revocations_;
}

std::shared_ptr<const KnownToken> TokenRegistry::FindInMemory(std::string_view text) const {
  const auto token = SplitToken(text);
  if (!token.has_value()) return nullptr;
  std::shared_ptr<const KnownToken> known;
  {
    const storage::MutexLock lock(mutex_);
    const auto found = known_.find(std::string(token->id));
    if (found == known_.end()) return nullptr;
    known = found->second;
  }
  return known->HasSecret(token->secret) ? known : nullptr;
}

absl::StatusOr<std::shared_ptr<const KnownToken>> TokenRegistry::Find(std::string_view text) {
  const auto token = SplitToken(text);
  if (!token.has_value()) return nullptr;
  const std::string id(token->id);
  while (true) {
    std::int64_t revocations_before = 0;
    {
      const storage::MutexLock lock(mutex_);
      const auto found = known_.find(id);
      if (found != known_.end()) {
        return found->second->HasSecret(token->secret) ? found->second : nullptr;
      }
      revocations_before = revocations_;
    }
    auto record = store_.GetToken(id);
    if (absl::IsNotFound(record.status())) return nullptr;
    if (!record.ok()) return record.status();
    if (!KnownToken(*record).HasSecret(token->secret)) return nullptr;
    const storage::MutexLock lock(mutex_);
    if (revocations_ == revocations_before) return Keep(*std::move(record), NowMicroseconds());
  }
}

std::shared_ptr<const KnownToken> TokenRegistry::Keep(storage::TokenRecord record,
                                                      std::int64_t now_us) {
  if (known_.size() >= next_sweep_) {
    std::erase_if(known_, [&](const auto& entry) { return entry.second->HasEnded(now_us); });
    next_sweep_ = std::max(next_sweep_, known_.size() + known_.size() / 2);
  }
  std::string id = record.id;
  auto token = std::make_shared<KnownToken>(std::move(record));
  return known_.emplace(std::move(id), std::move(token)).first->second;
}

}  // namespace motiondb::server
