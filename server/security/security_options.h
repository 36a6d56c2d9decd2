// What an operator decides about security, and what follows from it. Safe to use from any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/security/key_pair.h"
#include "storage/access_store.h"

namespace motiondb::server {

enum class Authentication {
  kByAddress,  // none on loopback, token elsewhere
  kNone,
  kToken
};

// What follows for who may call.
struct AccessOptions {
  bool authentication = false;  // without it everybody is an anonymous administrator
  std::string admin_token;      // counts as an administrator's token; empty: none
  // What a client may do that shows a certificate and no token; without it, nothing.
  std::optional<storage::Role> certificate_role;
  int failures_per_minute = 10;  // of one address, before its wrong tokens are not looked at
};

struct SecurityOptions {
  TlsFiles tls;
  Authentication authentication = Authentication::kByAddress;
  std::string admin_token_file;  // what it holds counts as an administrator's token
  std::optional<storage::Role> certificate_role;
  bool insecure = false;           // off loopback without TLS or authentication is allowed
  std::optional<bool> reflection;  // unset: where everybody may call
  int failures_per_minute = AccessOptions().failures_per_minute;
};

struct SecurityPlan {
  AccessOptions access;
  bool reflection = true;
  std::vector<std::string> warnings;  // to be shown to whoever starts the server
};

// Whether only programs on this machine reach `listen`, HOST:PORT.
bool IsLoopback(const std::string& listen);

// INVALID_ARGUMENT where the options do not fit each other, or a file is wrong, which it then
// names; FAILED_PRECONDITION off loopback without TLS and authentication, unless `insecure`.
absl::StatusOr<SecurityPlan> PlanSecurity(const SecurityOptions& options,
                                          const std::string& listen);

}  // namespace motiondb::server
