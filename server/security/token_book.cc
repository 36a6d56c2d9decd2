#include "server/security/token_book.h"

#include "core/motion/error.h"
#include "server/security/secret.h"

namespace motiondb::server {
namespace {

constexpr int kIdBytes = 6;
constexpr int kSaltBytes = 16;
constexpr int kSecretBytes = 32;

}  // namespace

bool KnownToken::HasSecret(std::string_view secret) const {
  return SameBytes(HashSecret(record_.salt, secret), record_.secret_hash);
}

absl::Status KnownToken::CheckHolds(std::int64_t now_us) const {
  if (ended_.load(std::memory_order_relaxed)) {
    return absl::UnauthenticatedError(fmt::format("tokens/{} was revoked", record_.id));
  }
  if (record_.expire_time_us != 0 && now_us >= record_.expire_time_us) {
    return absl::UnauthenticatedError(fmt::format("tokens/{} has expired", record_.id));
  }
  return absl::OkStatus();
}

absl::StatusOr<MadeToken> TokenBook::Make(storage::Role role, const std::string& database,
                                          const std::string& description, std::int64_t now_us,
                                          std::int64_t expire_time_us) {
  MadeToken made;
  storage::TokenRecord& record = made.record;
  MOTIONDB_ASSIGN_OR_RETURN(record.id, RandomHex(kIdBytes));
  MOTIONDB_ASSIGN_OR_RETURN(record.salt, RandomHex(kSaltBytes));
  MOTIONDB_ASSIGN_OR_RETURN(const std::string secret, RandomHex(kSecretBytes));
  record.secret_hash = HashSecret(record.salt, secret);
  record.role = role;
  record.database = database;
  record.description = description;
  record.create_time_us = now_us;
  record.expire_time_us = expire_time_us;
  MOTIONDB_RETURN_IF_ERROR(store_.AddToken(record));
  made.secret = JoinToken(record.id, secret);
  return made;
}

absl::StatusOr<storage::TokenRecord> TokenBook::Revoke(const std::string& id, std::int64_t now_us) {
  // Over the store's part too: nobody reads the token from there in between.
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(auto record, store_.RevokeToken(id, now_us));
  if (const auto known = known_.find(id); known != known_.end()) known->second->End();
  return record;
}

std::shared_ptr<const KnownToken> TokenBook::FindInMemory(std::string_view text) const {
  const auto token = SplitToken(text);
  if (!token.has_value()) return nullptr;
  std::shared_ptr<const KnownToken> known;
  {
    const std::shared_lock lock(mutex_);
    const auto found = known_.find(std::string(token->id));
    if (found == known_.end()) return nullptr;
    known = found->second;
  }
  return known->HasSecret(token->secret) ? known : nullptr;
}

absl::StatusOr<std::shared_ptr<const KnownToken>> TokenBook::Find(std::string_view text) {
  const auto token = SplitToken(text);
  if (!token.has_value()) return nullptr;
  const std::string id(token->id);
  const std::lock_guard lock(mutex_);
  const auto found = known_.find(id);
  if (found == known_.end()) {
    auto record = store_.GetToken(id);
    if (absl::IsNotFound(record.status())) return nullptr;
    if (!record.ok()) return record.status();
    auto stored = std::make_shared<KnownToken>(*std::move(record));
    if (!stored->HasSecret(token->secret)) return nullptr;
    return known_.emplace(id, std::move(stored)).first->second;
  }
  return found->second->HasSecret(token->secret) ? found->second : nullptr;
}

}  // namespace motiondb::server
