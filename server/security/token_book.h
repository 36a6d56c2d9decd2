// The bearer tokens: made, checked and revoked. Those that were read ahead, made or used are kept
// in memory until they end, so that a call costs one hash; revoking one ends it there at once.
// Thread-safe.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>

#include "absl/status/statusor.h"
#include "storage/access_store.h"
#include "storage/cancellable_lock.h"
#include "storage/mutex.h"

namespace motiondb::server {

// A token as it was stored, and whether it still holds.
class KnownToken {
 public:
  explicit KnownToken(storage::TokenRecord record)
      : record_(std::move(record)),
        state_(record_.revoke_time_us != 0 ? State::kEnded : State::kHolds) {}

  const storage::TokenRecord& record() const { return record_; }
  bool HasSecret(std::string_view secret) const;
  void End() { state_ = State::kEnded; }
  // Holds no more from here on, until its end is stored (End) or could not be (Resume). False if
  // somebody else is ending it, or has.
  bool Suspend() {
    State holds = State::kHolds;
    return state_.compare_exchange_strong(holds, State::kSuspended);
  }
  void Resume() {
    State suspended = State::kSuspended;
    state_.compare_exchange_strong(suspended, State::kHolds);
  }
  // For good.
  bool HasEnded(std::int64_t now_us) const;
  // UNAUTHENTICATED once it was revoked or its time is over.
  absl::Status CheckHolds(std::int64_t now_us) const;

 private:
  enum class State { kHolds, kSuspended, kEnded };
  bool HasExpired(std::int64_t now_us) const {
    return record_.expire_time_us != 0 && now_us >= record_.expire_time_us;
  }

  const storage::TokenRecord record_;
  std::atomic<State> state_;
};

struct MadeToken {
  storage::TokenRecord record;
  std::string secret;  // the whole of what its bearer sends
};

class TokenBook {
 public:
  using MakeAudit = std::function<storage::AuditRecord(const storage::TokenRecord&)>;

  // The store must outlive the book.
  explicit TokenBook(storage::AccessStore& store) : store_(store) {}

  // Takes stored tokens that hold at `now_us` into memory, the oldest hundred thousand of them; the
  // others come there when they are first used. The codes of the store.
  absl::Status ReadAhead(std::int64_t now_us);

  // `now_us` is when it is made; it ends at `expire_time_us`, or never where that is 0. `audit`,
  // where there is one, makes its entry of the record of changes, which is kept with it.
  absl::StatusOr<MadeToken> Make(storage::Role role, const std::string& database,
                                 const std::string& description, std::int64_t now_us,
                                 std::int64_t expire_time_us, const MakeAudit& audit = {},
                                 const core::Cancelled& cancelled = {});
  // Whether the last token of an administrator may be revoked; with kKeep it may not.
  enum class LastAdmin { kMayGo, kKeep };

  // Refuses its bearer at once, and returns when that is stored. FAILED_PRECONDITION if no other
  // token that holds would be left of an administrator of all databases, and one is to be kept;
  // NOT_FOUND, and the codes of the store. After an error the token holds as before.
  absl::StatusOr<storage::TokenRecord> Revoke(const std::string& id, std::int64_t now_us,
                                              const storage::ChangeTerms& terms = {},
                                              LastAdmin last_admin = LastAdmin::kMayGo);

  // Whether a token of an administrator of all databases holds at `now_us`. The codes of the store.
  absl::StatusOr<bool> HasAdmin(std::int64_t now_us) { return HasAdminBeside("", now_us); }

  // Whether `text` is the secret of a token in memory: looks nowhere else. Null if it is not.
  std::shared_ptr<const KnownToken> FindInMemory(std::string_view text) const;
  // The token that `text` is the secret of, whether or not it still holds. Null if there is none;
  // the codes of the store.
  absl::StatusOr<std::shared_ptr<const KnownToken>> Find(std::string_view text);

 private:
  std::int64_t revocations() const;
  // The same, whether or not the token `id` does.
  absl::StatusOr<bool> HasAdminBeside(const std::string& id, std::int64_t now_us);
  // FAILED_PRECONDITION if the token is the last one of an administrator. REQUIRES: the revoking
  // mutex is held.
  absl::Status CheckIsNotLastAdmin(const std::string& id, std::int64_t now_us);
  // Keeps a token in memory, and from time to time drops those that have ended: as many are there
  // as there are good ones, and half of that again. REQUIRES: the mutex is held.
  std::shared_ptr<const KnownToken> Keep(storage::TokenRecord record, std::int64_t now_us)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  storage::AccessStore& store_;
  // Held over the whole of a revocation that keeps the last administrator: of two who revoke each
  // other at once, the second one finds the other gone.
  storage::CancellableMutex revoking_mutex_;
  mutable storage::Mutex mutex_;
  std::unordered_map<std::string, std::shared_ptr<KnownToken>> known_ ABSL_GUARDED_BY(mutex_);
  // Nobody waits for the store under the mutex, so what was read there may be old by the time it is
  // kept: it is not kept if a token was revoked meanwhile.
  std::int64_t revocations_ ABSL_GUARDED_BY(mutex_) = 0;
  std::size_t next_sweep_ ABSL_GUARDED_BY(mutex_) =
      1024;  // as many known: time to drop those that have ended
};

}  // namespace motiondb::server
