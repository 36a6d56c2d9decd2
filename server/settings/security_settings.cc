#include <string>
#include <utility>

#include "core/motion/error.h"
#include "server/settings/groups.h"
#include "storage/store_url.h"

namespace motiondb::server {
namespace {

constexpr Words<Authentication, 3> kAuthentication{{{"by-address", Authentication::kByAddress},
                                                    {"token", Authentication::kToken},
                                                    {"none", Authentication::kNone}}};

constexpr Words<std::optional<storage::Role>, 4> kRoles{{{"none", std::nullopt},
                                                         {"reader", storage::Role::kReader},
                                                         {"ingester", storage::Role::kIngester},
                                                         {"admin", storage::Role::kAdmin}}};

}  // namespace

void AddSecuritySettings(CLI::App& app, Settings& settings) {
  SecurityOptions& security = settings.server.security;
  constexpr char kGroup[] = "Security";
  app.add_option("--tls-certificate", security.tls.certificate,
                 "Certificate of the server with intermediate certificates, PEM; reloaded when it "
                 "changes")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--tls-key", security.tls.key, "Private key of the certificate, PEM")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option(
         "--tls-client-ca", security.tls.client_ca,
         "Authorities of client certificates, PEM; if set, every client needs a certificate")
      ->type_name("FILE")
      ->group(kGroup);
  AddWord(app, "--authentication", security.authentication, kAuthentication,
          "token: every call needs a token; none: no authentication; by-address: none if only this "
          "machine can reach --listen, otherwise token")
      ->group(kGroup);
  app.add_option("--admin-token-file", security.admin_token_file,
                 "File with a token of the role admin; only its owner may write it, and not all "
                 "users may read it; reloaded when it changes")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--tls-peer-ca", security.peer_ca,
                 "Authorities of the certificates of other servers of the same store, PEM; if not "
                 "set: those of the system")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--tls-peer-name", security.peer_name,
                 "Name in the certificates of other servers of the same store, if it is not the "
                 "host of their --advertise")
      ->type_name("NAME")
      ->group(kGroup);
  AddWord(app, "--certificate-role", security.certificate_role, kRoles,
          "Role of a client that has a certificate and no token")
      ->group(kGroup);
  AddCount(app, "--failures-per-minute", security.failures_per_minute, 1, 1'000'000,
           "Wrong tokens per minute and address; then unknown tokens of the address are refused "
           "for up to a minute")
      ->group(kGroup);
  app.add_flag("--insecure", security.insecure,
               "Allow other machines without TLS or without authentication")
      ->group(kGroup);
}

void CheckSecuritySettings(const Settings& settings, std::vector<absl::Status>& problems) {
  const auto plan = DeriveSecurityConfig(settings.server.security, settings.server.listen,
                                         settings.server.web_listen);
  if (!plan.ok()) problems.push_back(plan.status());
  const SecurityOptions& security = settings.server.security;
  if (security.peer_ca.empty() && security.peer_name.empty()) return;
  if (storage::IsPostgresUrl(settings.store_path)) return;
  problems.push_back(
      core::InvalidArgument("{}: expected no value, because a file has only one server; servers "
                            "share a store in PostgreSQL",
                            security.peer_ca.empty() ? "tls-peer-name" : "tls-peer-ca"));
}

}  // namespace motiondb::server
