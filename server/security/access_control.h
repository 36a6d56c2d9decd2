// Who calls, what they may do, and the record of what they changed. Thread-safe.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "server/security/attempt_limit.h"
#include "server/security/authorize.h"
#include "server/security/security_options.h"
#include "server/security/token_book.h"
#include "storage/access_store.h"
#include "storage/mutex.h"

namespace motiondb::server {

class AccessControl {
 public:
  // The store must outlive this. Reads its tokens ahead; those that cannot be read now are when
  // they are first used.
  AccessControl(storage::AccessStore& store, const AccessOptions& options);

  // UNAUTHENTICATED, saying what is lacking; RESOURCE_EXHAUSTED with RetryInfo for a token that is
  // not known to be good, from an address that failed too often. Tokens in memory (TokenBook) go on
  // to work there: who shares an address with somebody who guesses is not locked out. What fails is
  // logged with the address, once a minute for each kind of failure, and never with the token.
  absl::StatusOr<Caller> Authenticate(const Evidence& evidence);
  // Whether what the caller was known by still holds. UNAUTHENTICATED.
  absl::Status Recheck(const Caller& caller) const;

  // Puts another token in the place of the administrator's, of which whoever is known by it is
  // known no more. False if it is the same.
  bool ReplaceAdminToken(const std::string& token);

  // As TokenBook::Revoke. The last token of an administrator is kept unless somebody can administer
  // without one: everybody, who has the administrator's token of the file, or a certificate.
  absl::StatusOr<storage::TokenRecord> RevokeToken(const std::string& id, std::int64_t now_us,
                                                   const storage::ChangeTerms& terms = {});

  // Whether somebody can administer the server at `now_us`, with a token or without. True where the
  // tokens cannot be read.
  bool CanBeAdministered(std::int64_t now_us);

  // Keeps an entry of the record of changes. Those of calls that changed nothing, as where they
  // failed, of others than administrators, are kept only so often from one source, so that nobody
  // can push the rest out with them. As KeepAuditRecord.
  absl::Status Record(const storage::AuditRecord& record, bool of_administrator, bool changed,
                      const core::Cancelled& cancelled = {});

  TokenBook& tokens() { return tokens_; }
  storage::AccessStore& store() { return store_; }
  bool authentication() const { return options_.authentication; }

 private:
  absl::StatusOr<Caller> ByToken(const std::string& bearer, const std::string& address);
  // Null if it is not the administrator's.
  std::shared_ptr<const KnownToken> FindAdminToken(const std::string& bearer) const;
  bool CanAdministerWithoutToken() const;
  // Logs it and returns `status`. `what` the caller at the address showed: the kind of failure.
  absl::Status Fail(std::string_view what, const std::string& address, absl::Status status);

  storage::AccessStore& store_;
  const AccessOptions options_;
  mutable storage::Mutex admin_mutex_;
  std::shared_ptr<KnownToken> admin_token_ ABSL_GUARDED_BY(admin_mutex_);  // null: there is none
  TokenBook tokens_;
  AttemptLimit failures_;
  AttemptLimit recorded_in_vain_;
  AttemptLimit warnings_;
};

}  // namespace motiondb::server
