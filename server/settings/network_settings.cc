#include <string>

#include "core/motion/error.h"
#include "server/observability/health_server.h"
#include "server/settings/groups.h"
#include "server/settings/options.h"

namespace motiondb::server {

void AddNetworkSettings(CLI::App& app, Settings& settings) {
  app.add_option("--listen", settings.server.listen,
                 "Where to answer gRPC; port 0 takes a free one")
      ->type_name("HOST:PORT")
      ->check(ListenAddress())
      ->capture_default_str()
      ->group("Network");
  AddSeconds(app, "--grace-seconds", settings.grace, 0, 3600,
             "How long running calls may take after SIGTERM")
      ->group("Network");
}

namespace {

// An address, or the word that means that there is none.
CLI::Validator ListenAddressOrNone() {
  return CLI::Validator(
      [address = ListenAddress()](std::string& text) {
        return text.empty() || text == "none" ? std::string() : address(text);
      },
      "");
}

struct Address {
  explicit Address(const std::string& listen)
      : host(listen.substr(0, listen.rfind(':'))), port(listen.substr(listen.rfind(':') + 1)) {
    if (host == "localhost") host = "127.0.0.1";
  }
  bool is_everywhere() const { return host == "0.0.0.0" || host == "[::]"; }

  std::string host;
  std::string port;
};

// Whether who listens at one keeps another from listening at the other.
bool Clash(const Address& one, const Address& other) {
  if (std::stoi(one.port) == 0 || std::stoi(one.port) != std::stoi(other.port)) return false;
  return one.host == other.host || one.is_everywhere() || other.is_everywhere();
}

}  // namespace

void AddHttpSettings(CLI::App& app, Settings& settings) {
  app.add_option(
         "--http-listen", settings.http_listen,
         "Where to answer HTTP: /metrics, /livez, /readyz, without authentication; port 0 "
         "takes a free one, none is for no HTTP; without it 127.0.0.1:9464, if that is free")
      ->type_name("HOST:PORT")
      ->check(ListenAddressOrNone())
      ->capture_default_str()
      ->group("Network");
}

void CheckHttpSettings(const Settings& settings, std::vector<absl::Status>& problems) {
  if (settings.http_listen == "none") return;
  const bool is_default = settings.http_listen.empty();
  const std::string http = is_default ? kDefaultHttpListen : settings.http_listen;
  const std::string& listen = settings.server.listen;
  if (!Clash(Address(listen), Address(http))) return;
  problems.push_back(core::InvalidArgument(
      "listen and http-listen: {} and {}{} cannot both be listened at; give each a port of its own",
      listen, http, is_default ? ", the default," : ""));
}

void AddLogSettings(CLI::App& app, Settings& settings) {
  app.add_option("--log-level", settings.log.level, "What to log on standard error")
      ->type_name("LEVEL")
      ->check(CLI::IsMember({"debug", "info", "warning", "error", "off"}))
      ->capture_default_str()
      ->group("Log");
  app.add_option_function<std::string>(
         "--log-format",
         [&settings](const std::string& format) {
           settings.log.format = format == "json" ? LogFormat::kJson : LogFormat::kText;
         },
         "Lines of text for a person, or one JSON object a line")
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"text", "json"}))
      ->default_str("text")
      ->group("Log");
  AddSeconds(app, "--slow-call-seconds", settings.log.slow_call, 0, 3600,
             "From how long on a call is logged as slow, with a warning; 0: never")
      ->group("Log");
}

}  // namespace motiondb::server
