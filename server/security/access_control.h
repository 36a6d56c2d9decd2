// Authentication of calls, revocation of tokens, and entries of the audit log.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "server/security/attempt_limit.h"
#include "server/security/authorize.h"
#include "server/security/security_options.h"
#include "server/security/token_registry.h"
#include "storage/access_store.h"
#include "storage/mutex.h"

namespace motiondb::server {

class AccessControl {
 public:
  // Loads the tokens of the store into memory. A token that cannot be loaded now is loaded at its
  // first use. The store must outlive this object.
  AccessControl(storage::AccessStore& store, const AccessOptions& options);

  // Returns the caller. Errors: UNAUTHENTICATED with the reason; RESOURCE_EXHAUSTED with RetryInfo
  // for an unknown token from an address with too many failures. Tokens in memory (TokenRegistry)
  // still work from such an address, so that a valid client behind the same NAT is not locked out.
  // Logs a failure with its address, at most once a minute for each kind of failure, and never logs
  // the token.
  absl::StatusOr<Caller> Authenticate(const PeerCredentials& credentials);
  // Returns UNAUTHENTICATED if the caller's token is no longer valid.
  absl::Status Recheck(const Caller& caller) const;

  // Replaces the token of the admin token file. Callers with the old token lose access. Returns
  // false if the token did not change.
  bool ReplaceAdminToken(const std::string& token);

  // Like TokenRegistry::Revoke. Keeps the last admin token unless admin access is possible without
  // it: authentication is off, there is an admin token file, or certificates have the role admin.
  absl::StatusOr<storage::TokenRecord> RevokeToken(const std::string& id, std::int64_t now_us,
                                                   const storage::WriteOptions& terms = {});

  // Returns whether admin access is possible at `now_us`, with a token or without. Returns true if
  // the tokens cannot be read.
  bool HasAdminAccess(std::int64_t now_us);

  // Adds an entry to the audit log, with StoreAuditRecord. Entries of calls that changed nothing
  // (for example, failed calls) are limited to 10 a minute for each source and principal, unless
  // the caller is an admin. So a client cannot displace other entries by calls that fail.
  absl::Status Record(const storage::AuditRecord& record, bool of_administrator, bool changed,
                      const core::Cancelled& cancelled = {});

  TokenRegistry& tokens() { return tokens_; }
  storage::AccessStore& store() { return store_; }
  bool authentication() const { return options_.authentication; }

 private:
  absl::StatusOr<Caller> ByToken(const std::string& bearer, const std::string& address);
  // Returns null if `bearer` is not the token of the admin token file.
  std::shared_ptr<const KnownToken> FindAdminToken(const std::string& bearer) const;
  bool CanAdministerWithoutToken() const;
  // Logs the failure of kind `what` and returns `status`.
  absl::Status Fail(std::string_view what, const std::string& address, absl::Status status);

  storage::AccessStore& store_;
  const AccessOptions options_;
  mutable storage::Mutex admin_mutex_;
  std::shared_ptr<KnownToken> admin_token_ ABSL_GUARDED_BY(admin_mutex_);  // null: no file
  TokenRegistry tokens_;
  AttemptLimit failures_;
  AttemptLimit no_change_entries_;
  AttemptLimit warnings_;
};

}  // namespace motiondb::server
