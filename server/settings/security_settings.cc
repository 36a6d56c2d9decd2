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

// An option whose value is one of a few words, the first being the default.
template <typename Value, std::size_t kCount>
CLI::Option* AddWord(CLI::App& app, const std::string& name, Value& value,
                     const Words<Value, kCount>& words, const std::string& description) {
  std::vector<std::string> known;
  for (const auto& [word, meaning] : words) known.emplace_back(word);
  return app
      .add_option_function<std::string>(
          name,
          [&value, &words](const std::string& given) {
            for (const auto& [word, meaning] : words) {
              if (given == word) value = meaning;
            }
          },
          description)
      ->check(CLI::IsMember(known))
      ->default_str(known.front());
}

}  // namespace

void AddSecuritySettings(CLI::App& app, Settings& settings) {
  SecurityOptions& security = settings.server.security;
  constexpr char kGroup[] = "Security";
  app.add_option("--tls-certificate", security.tls.certificate,
                 "The server's certificate, PEM, with those between it and its authority; read "
                 "again when it changes")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--tls-key", security.tls.key, "The certificate's key, PEM")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--tls-client-ca", security.tls.client_ca,
                 "Who signs the certificates of clients, PEM; every client then needs one")
      ->type_name("FILE")
      ->group(kGroup);
  AddWord(app, "--authentication", security.authentication, kAuthentication,
          "Who may call: token: who shows one; none: everybody; by-address: everybody if only "
          "this machine can reach --listen, else who shows a token")
      ->group(kGroup);
  app.add_option("--admin-token-file", security.admin_token_file,
                 "What it holds counts as an administrator's token; not to be readable by all, nor "
                 "writable by others than its owner; read again when it changes")
      ->type_name("FILE")
      ->group(kGroup);
  AddWord(app, "--certificate-role", security.certificate_role, kRoles,
          "What a client may do that shows a certificate and no token")
      ->group(kGroup);
  AddCount(app, "--failures-per-minute", security.failures_per_minute, 1, 1'000'000,
           "Wrong tokens of one address after which more are not looked at for a while")
      ->group(kGroup);
  AddWord(app, "--reflection", security.reflection, kReflection,
          "Tell every caller, also without a token, which calls there are; auto: where everybody "
          "may call")
      ->group(kGroup);
  app.add_flag("--insecure", security.insecure,
               "Serve other machines although there is no TLS or no authentication")
      ->group(kGroup);
}

void CheckSecuritySettings(const Settings& settings, std::vector<absl::Status>& problems) {
  const auto plan = PlanSecurity(settings.server.security, settings.server.listen);
  if (!plan.ok()) problems.push_back(plan.status());
}

}  // namespace motiondb::server
