#include "server/security/security_options.h"

#include <arpa/inet.h>
#include <sys/stat.h>

#include "core/motion/error.h"
#include "server/security/operator_file.h"

namespace motiondb::server {
namespace {

absl::Status CheckTls(const SecurityOptions& options) {
  const TlsFiles& tls = options.tls;
  if (tls.certificate.empty() != tls.key.empty()) {
    return core::InvalidArgument("a TLS certificate and its key are given together or not at all");
  }
  if (!tls.enabled() && !tls.client_ca.empty()) {
    return core::InvalidArgument(
        "certificates of clients (tls-client-ca) need a certificate of the server");
  }
  if (tls.client_ca.empty() && options.certificate_role.has_value()) {
    return core::InvalidArgument("certificate-role needs tls-client-ca");
  }
  return tls.enabled() ? ReadTlsFiles(tls).status() : absl::OkStatus();
}

// A key is only warned of: what mounts secrets may leave them open to all, where nobody else is.
void WarnOfKey(const std::string& key, std::vector<std::string>& warnings) {
  struct stat status;
  if (key.empty() || stat(key.c_str(), &status) != 0) return;
  const std::string_view fault = FaultOfMode(status.st_mode);
  if (fault.empty()) return;
  warnings.push_back(
      fmt::format("{}: {}, and whoever has this key can pass for the server; expected mode {}", key,
                  fault, kSecretModes));
}

}  // namespace

bool IsLoopback(const std::string& listen) {
  std::string host = listen.substr(0, listen.rfind(':'));
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  in_addr v4;
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return ntohl(v4.s_addr) >> 24 == 127;
  return host == "::1" || host == "localhost";
}

absl::StatusOr<SecurityPlan> PlanSecurity(const SecurityOptions& options,
                                          const std::string& listen) {
  MOTIONDB_RETURN_IF_ERROR(CheckTls(options));
  const bool loopback = IsLoopback(listen);
  const bool encrypted = options.tls.enabled();
  SecurityPlan plan;
  // A token over plain text is nobody's alone, and the client library sends none: where plain text
  // was asked for, tokens are only if they were, too.
  plan.access.authentication = options.authentication == Authentication::kByAddress
                                   ? !loopback && (encrypted || !options.insecure)
                                   : options.authentication == Authentication::kToken;
  plan.access.failures_per_minute = options.failures_per_minute;
  plan.access.certificate_role = options.certificate_role;
  plan.reflection = options.reflection.value_or(!plan.access.authentication);
  if (!options.admin_token_file.empty()) {
    MOTIONDB_ASSIGN_OR_RETURN(plan.access.admin_token, ReadAdminToken(options.admin_token_file));
  }
  WarnOfKey(options.tls.key, plan.warnings);
  if (loopback && !plan.access.authentication &&
      (!options.admin_token_file.empty() || options.certificate_role.has_value())) {
    plan.warnings.push_back(fmt::format(
        "nobody is asked for a token at {}: admin-token-file and certificate-role have no effect "
        "without --authentication token",
        listen));
  }
  if (loopback || (encrypted && plan.access.authentication)) return plan;

  const std::string lacks = fmt::format("{}{}{}", encrypted ? "" : "TLS",
                                        encrypted || plan.access.authentication ? "" : " and ",
                                        plan.access.authentication ? "" : "authentication");
  if (!options.insecure) {
    return core::FailedPrecondition(
        "{} can be reached from other machines, and there is no {}: give --tls-certificate and "
        "--tls-key, leave --authentication at token, or listen on 127.0.0.1; --insecure serves "
        "without",
        listen, lacks);
  }
  plan.warnings.push_back(fmt::format(
      "INSECURE: {} can be reached from other machines, and there is no {}.{}{}", listen, lacks,
      encrypted ? "" : " Whoever is on the way reads and changes what is sent.",
      plan.access.authentication ? "" : " Whoever reaches it may read, change and delete all."));
  return plan;
}

}  // namespace motiondb::server
