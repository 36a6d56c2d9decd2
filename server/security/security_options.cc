#include "server/security/security_options.h"

#include <arpa/inet.h>
#include <sys/stat.h>

#include "core/motion/error.h"
#include "server/security/operator_files.h"

namespace motiondb::server {
namespace {

absl::Status CheckTls(const SecurityOptions& options) {
  const TlsFiles& tls = options.tls;
  if (tls.certificate.empty() != tls.key.empty()) {
    return core::InvalidArgument("expected tls-certificate and tls-key together, got only one");
  }
  if (!tls.enabled() && !tls.client_ca.empty()) {
    return core::InvalidArgument("tls-client-ca needs tls-certificate and tls-key");
  }
  if (!tls.enabled() && !options.peer_ca.empty()) {
    return core::InvalidArgument("tls-peer-ca needs tls-certificate and tls-key");
  }
  if (!tls.enabled() && !options.peer_name.empty()) {
    return core::InvalidArgument("tls-peer-name needs tls-certificate and tls-key");
  }
  if (tls.client_ca.empty() && options.certificate_role.has_value()) {
    return core::InvalidArgument("certificate-role needs tls-client-ca");
  }
  return tls.enabled() ? ReadTlsFiles(tls).status() : absl::OkStatus();
}

// Warns about the mode of the key file. It is no error: container platforms may mount secrets
// readable by all, in a container without other users.
void WarnOfKey(const std::string& key, std::vector<std::string>& warnings) {
  struct stat status;
  if (key.empty() || stat(key.c_str(), &status) != 0) return;
  const std::string_view fault = ModeFault(status.st_mode);
  if (fault.empty()) return;
  warnings.push_back(
      fmt::format("{}: {}; a program with this key can impersonate the server; expected mode {}",
                  key, fault, kSecretModes));
}

}  // namespace

bool IsLoopback(const std::string& listen) {
  std::string host = listen.substr(0, listen.rfind(':'));
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  in_addr v4;
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return ntohl(v4.s_addr) >> 24 == 127;
  return host == "::1" || host == "localhost";
}

absl::StatusOr<SecurityConfig> DeriveSecurityConfig(const SecurityOptions& options,
                                                    const std::string& grpc_listen,
                                                    const std::string& web_listen) {
  MOTIONDB_RETURN_IF_ERROR(CheckTls(options));
  // All listeners have the same protection: that of the most exposed one.
  const bool is_web = IsLoopback(grpc_listen) && !web_listen.empty() && !IsLoopback(web_listen);
  const std::string& listen = is_web ? web_listen : grpc_listen;
  const bool loopback = IsLoopback(listen);
  const bool encrypted = options.tls.enabled();
  SecurityConfig plan;
  // A token over plain text is readable on the network, and the client library sends none. So with
  // --insecure and without TLS, tokens are required only if the operator sets it.
  plan.access.authentication = options.authentication == Authentication::kByAddress
                                   ? !loopback && (encrypted || !options.insecure)
                                   : options.authentication == Authentication::kToken;
  plan.access.failures_per_minute = options.failures_per_minute;
  plan.access.certificate_role = options.certificate_role;
  plan.reflection = !plan.access.authentication;
  if (!options.admin_token_file.empty()) {
    MOTIONDB_ASSIGN_OR_RETURN(plan.access.admin_token, ReadAdminToken(options.admin_token_file));
  }
  WarnOfKey(options.tls.key, plan.warnings);
  if (loopback && !plan.access.authentication &&
      (!options.admin_token_file.empty() || options.certificate_role.has_value())) {
    plan.warnings.push_back(fmt::format(
        "authentication is off at {}: admin-token-file and certificate-role have no effect; set "
        "--authentication token",
        listen));
  }
  if (loopback || (encrypted && plan.access.authentication)) return plan;

  const std::string lacks = fmt::format("{}{}{}", encrypted ? "" : "TLS",
                                        encrypted || plan.access.authentication ? "" : " and ",
                                        plan.access.authentication ? "" : "authentication");
  if (!options.insecure) {
    return core::FailedPrecondition(
        "{} is reachable from other machines without {}; set --tls-certificate, --tls-key and "
        "--authentication token, or listen on 127.0.0.1; --insecure allows it",
        listen, lacks);
  }
  plan.warnings.push_back(fmt::format(
      "INSECURE: {} is reachable from other machines without {}.{}{}", listen, lacks,
      encrypted ? "" : " Traffic is not encrypted.",
      plan.access.authentication ? "" : " Every client can read, change and delete everything."));
  return plan;
}

}  // namespace motiondb::server
