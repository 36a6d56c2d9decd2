// Security settings of the operator and the configuration derived from them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/security/operator_files.h"
#include "storage/access_store.h"

namespace motiondb::server {

enum class Authentication {
  kByAddress,  // none on loopback, token elsewhere
  kNone,
  kToken
};

// Configuration of AccessControl.
struct AccessOptions {
  bool authentication = false;  // false: every caller is an anonymous admin
  std::string admin_token;      // accepted with the role admin; empty: none
  // Role of a client with a certificate and no token; unset: a token is required.
  std::optional<storage::Role> certificate_role;
  int failures_per_minute = 10;  // of one address; then its unknown tokens are refused unchecked
};

struct SecurityOptions {
  TlsFiles tls;
  // Authorities of the certificates of other servers of the store; empty: those of the system.
  std::string peer_ca;
  std::string peer_name;  // in their certificates; empty: the host of the address
  Authentication authentication = Authentication::kByAddress;
  std::string admin_token_file;  // path; its token has the role admin
  std::optional<storage::Role> certificate_role;
  bool insecure = false;  // allows other machines without TLS or authentication
  int failures_per_minute = AccessOptions().failures_per_minute;
};

struct SecurityConfig {
  AccessOptions access;
  bool reflection = true;  // gRPC server reflection, which needs no token: without authentication
  std::vector<std::string> warnings;  // for the operator, at start
};

// Returns whether only this machine can reach `listen`, HOST:PORT.
bool IsLoopback(const std::string& listen);

// Derives the configuration. Returns INVALID_ARGUMENT if options contradict each other or a file is
// invalid (with its path); FAILED_PRECONDITION if other machines can reach an address without TLS
// or authentication, unless `insecure` is set. `web_listen`: address of the HTTP API; empty: none.
absl::StatusOr<SecurityConfig> DeriveSecurityConfig(const SecurityOptions& options,
                                                    const std::string& listen,
                                                    const std::string& web_listen = "");

}  // namespace motiondb::server
