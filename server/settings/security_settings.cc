#include <array>
#include <string>
#include <utility>

#include "server/settings/groups.h"
#include "server/settings/options.h"

namespace motiondb::server {
namespace {

template <typename Value, std::size_t kCount>
using Words = std::array<std::pair<const char*, Value>, kCount>;

constexpr Words<Authentication, 3> kAuthentication{{{"by-address", Authentication::kByAddress},
                                                    {"token", Authentication::kToken},
                                                    {"none", Authentication::kNone}}};

constexpr Words<std::optional<storage::Role>, 4> kRoles{{{"none", std::nullopt},
                                                         {"reader", storage::Role::kReader},
                                                         {"ingester", storage::Role::kIngester},
                                                         {"admin", storage::Role::kAdmin}}};

constexpr Words<std::optional<bool>, 3> kReflection{
    {{"auto", std::nullopt}, {"on", true}, {"off", false}}};

// Adds an option with a fixed set of words as values. The first word is the default.
template <typename Value, std::size_t kCount>
CLI::Option* AddWord(CLI::App& app, const std::string& name, Value& value,
                     const Words<Value, kCount>& words, const std::string& description) {
  std::vector<std::string> allowed;
  for (const auto& [word, meaning] : words) allowed.emplace_back(word);
  return app
      .add_option_function<std::string>(
          name,
          [&value, &words](const std::string& given) {
            for (const auto& [word, meaning] : words) {
              if (given == word) value = meaning;
            }
          },
          description)
      ->check(CLI::IsMember(allowed))
      ->default_str(allowed.front());
}

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
  AddWord(app, "--certificate-role", security.certificate_role, kRoles,
          "Role of a client that has a certificate and no token")
      ->group(kGroup);
  AddCount(app, "--failures-per-minute", security.failures_per_minute, 1, 1'000'000,
           "Wrong tokens per minute and address; then unknown tokens of the address are refused "
           "for up to a minute")
      ->group(kGroup);
  AddWord(app, "--reflection", security.reflection, kReflection,
          "gRPC server reflection, which needs no token; auto: on if authentication is off")
      ->group(kGroup);
  app.add_flag("--insecure", security.insecure,
               "Allow other machines without TLS or without authentication")
      ->group(kGroup);
}

void CheckSecuritySettings(const Settings& settings, std::vector<absl::Status>& problems) {
  const auto plan = DeriveSecurityConfig(settings.server.security, settings.server.listen,
                                         settings.server.web_listen);
  if (!plan.ok()) problems.push_back(plan.status());
}

}  // namespace motiondb::server
