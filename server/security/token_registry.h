// Creates, checks and revokes bearer tokens. A token is `mdb_{id}_{secret}`. The id (48 bits) is
// public. The secret has 256 random bits, so a salted SHA-256 is as safe as a slow password hash.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "absl/status/statusor.h"
#include "storage/access_store.h"
#include "storage/cancellable_lock.h"
#include "storage/mutex.h"

namespace motiondb::server {

// Returns `bytes` random bytes in hexadecimal. Returns INTERNAL if the random generator fails.
absl::StatusOr<std::string> RandomHex(int bytes);

// Returns the SHA-256 of salt and secret: 32 bytes.
std::string HashSecret(std::string_view salt, std::string_view secret);

// Compares in constant time.
bool SameBytes(std::string_view a, std::string_view b);

struct BearerToken {
  std::string_view id;
  std::string_view secret;
};

// Splits `mdb_{id}_{secret}`. Returns nullopt for another form. The result refers to `text`.
std::optional<BearerToken> SplitToken(std::string_view text);
std::string JoinToken(std::string_view id, std::string_view secret);

// A stored token and whether it is still valid.
class KnownToken {
 public:
  explicit KnownToken(storage::TokenRecord record)
      : record_(std::move(record)),
        state_(record_.revoke_time_us != 0 ? State::kEnded : State::kValid) {}

  const storage::TokenRecord& record() const { return record_; }
  bool HasSecret(std::string_view secret) const;
  void End() { state_ = State::kEnded; }
  // Makes the token invalid until its revocation is stored (End) or fails (Resume). Returns false
  // if the token is already suspended or ended.
  bool Suspend() {
    State expected = State::kValid;
    return state_.compare_exchange_strong(expected, State::kSuspended);
  }
  void Resume() {
    State expected = State::kSuspended;
    state_.compare_exchange_strong(expected, State::kValid);
  }
  // Returns whether the token can never become valid again; false while suspended.
  bool HasEnded(std::int64_t now_us) const;
  // Returns UNAUTHENTICATED if the token is revoked, suspended or expired.
  absl::Status CheckValid(std::int64_t now_us) const;

 private:
  enum class State { kValid, kSuspended, kEnded };
  bool HasExpired(std::int64_t now_us) const {
    return record_.expire_time_us != 0 && now_us >= record_.expire_time_us;
  }

  const storage::TokenRecord record_;
  std::atomic<State> state_;
};

struct CreatedToken {
  storage::TokenRecord record;
  std::string secret;  // `mdb_{id}_{secret}`, as the client sends it
};

// Tokens that were preloaded, created or used stay in memory while they are valid, so the check of
// a call costs one hash. A revocation takes effect in memory immediately.
class TokenRegistry {
 public:
  using MakeAudit = std::function<storage::AuditRecord(const storage::TokenRecord&)>;

  // The store must outlive this object.
  explicit TokenRegistry(storage::AccessStore& store) : store_(store) {}

  // Loads the stored tokens that are valid at `now_us`, at most 100,000, oldest first; others are
  // loaded at their first use. Returns errors of the store.
  absl::Status ReadAhead(std::int64_t now_us);

  // Creates a token at `now_us` that expires at `expire_time_us`; 0: never. `audit`, if set, makes
  // the entry of the audit log, which is stored in the same transaction.
  absl::StatusOr<CreatedToken> Make(storage::Role role, const std::string& database,
                                    const std::string& description, std::int64_t now_us,
                                    std::int64_t expire_time_us, const MakeAudit& audit = {},
                                    const core::Cancelled& cancelled = {});
  // Whether the last admin token may be revoked (kMayRevoke) or not (kKeep).
  enum class LastAdmin { kMayRevoke, kKeep };

  // Refuses the token immediately and returns when the revocation is durable. Returns
  // FAILED_PRECONDITION if the token is the last valid admin token for all databases and
  // `last_admin` is kKeep; NOT_FOUND; errors of the store. After an error the token is valid as
  // before.
  absl::StatusOr<storage::TokenRecord> Revoke(const std::string& id, std::int64_t now_us,
                                              const storage::WriteOptions& terms = {},
                                              LastAdmin last_admin = LastAdmin::kMayRevoke);

  // Ends the tokens in memory that another server has revoked. Reads all tokens. Returns errors of
  // the store.
  absl::Status FollowRevocations();

  // Returns whether a valid admin token for all databases exists at `now_us`. Returns errors of the
  // store.
  absl::StatusOr<bool> HasAdmin(std::int64_t now_us) { return HasAdminBeside("", now_us); }

  // Returns the token in memory whose secret is `text`; otherwise null. Does not read the store.
  std::shared_ptr<const KnownToken> FindInMemory(std::string_view text) const;
  // Returns the token whose secret is `text`, valid or not; null if unknown. Returns errors of the
  // store.
  absl::StatusOr<std::shared_ptr<const KnownToken>> Find(std::string_view text);

 private:
  std::int64_t revocations() const;
  // Like HasAdmin, but ignores the token `id`.
  absl::StatusOr<bool> HasAdminBeside(const std::string& id, std::int64_t now_us);
  // Returns FAILED_PRECONDITION if the token is the last admin token. REQUIRES: `revoking_mutex_`
  // is locked.
  absl::Status CheckIsNotLastAdmin(const std::string& id, std::int64_t now_us);
  // Adds a token to memory. Sometimes removes ended tokens, so that memory holds at most about 1.5
  // times the valid tokens. REQUIRES: `mutex_` is locked.
  std::shared_ptr<const KnownToken> Keep(storage::TokenRecord record, std::int64_t now_us)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  storage::AccessStore& store_;
  // Locked during a whole revocation with kKeep: if two admins revoke each other concurrently, the
  // second revocation is refused.
  storage::CancellableMutex revoking_mutex_;
  mutable storage::Mutex mutex_;
  std::unordered_map<std::string, std::shared_ptr<KnownToken>> known_ ABSL_GUARDED_BY(mutex_);
  // The store is read without `mutex_`, so a record may be out of date when it is added. It is
  // added only if this count is unchanged since the read began.
  std::int64_t revocations_ ABSL_GUARDED_BY(mutex_) = 0;
  std::size_t next_sweep_ ABSL_GUARDED_BY(mutex_) = 1024;  // token count of the next removal
};

}  // namespace motiondb::server
