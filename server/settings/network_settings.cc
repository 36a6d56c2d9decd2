#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <vector>

#include "core/motion/error.h"
#include "server/observability/health_server.h"
#include "server/settings/groups.h"

namespace motiondb::server {

namespace {

// Accepts an address, the word none, or an empty value.
CLI::Validator ListenAddressOrNone() {
  return CLI::Validator(
      [address = ListenAddress()](std::string& text) {
        return text.empty() || text == "none" ? std::string() : address(text);
      },
      "");
}

struct Address {
  // `listen` has passed ListenAddress.
  explicit Address(const std::string& listen)
      : host(listen.substr(0, listen.rfind(':'))), port(listen.substr(listen.rfind(':') + 1)) {
    if (host == "localhost") host = "127.0.0.1";
  }
  bool is_everywhere() const { return host == "0.0.0.0" || host == "[::]"; }

  std::string host;
  std::string port;
};

// Accepts an address that other machines can connect to, or an empty value.
CLI::Validator ReachableAddress() {
  return CLI::Validator(
      [is_address = ListenAddress()](std::string& text) {
        if (text.empty()) return std::string();
        if (std::string wrong = is_address(text); !wrong.empty()) return wrong;
        const Address address(text);
        if (!address.is_everywhere() && std::stoi(address.port) != 0) return std::string();
        return fmt::format("expected the host and port of one server, got '{}'", text);
      },
      "");
}

// Returns whether two listeners cannot use these addresses at the same time.
bool Clash(const Address& a, const Address& b) {
  if (std::stoi(a.port) == 0 || std::stoi(a.port) != std::stoi(b.port)) return false;
  return a.host == b.host || a.is_everywhere() || b.is_everywhere();
}

}  // namespace

void AddNetworkSettings(CLI::App& app, Settings& settings) {
  app.add_option("--listen", settings.server.listen,
                 "Address of the gRPC listener; port 0: any free port")
      ->type_name("HOST:PORT")
      ->check(ListenAddress())
      ->capture_default_str()
      ->group("Network");
  app.add_option("--advertise", settings.server.advertise,
                 "Address at which other servers of the same store reach this one, to watch its "
                 "streams; if not set: the address of --listen, unless that is all addresses")
      ->type_name("HOST:PORT")
      ->check(ReachableAddress())
      ->group("Network");
  app.add_option_function<std::string>(
         "--web-listen",
         [&settings](const std::string& listen) {
           settings.server.web_listen = listen == "none" ? "" : listen;
         },
         "Address of the web page and of the HTTP API: every RPC by the Connect protocol, as JSON "
         "or protobuf, with the TLS and the authentication of the gRPC listener; port 0: any free "
         "port; none: no web page and no HTTP API")
      ->type_name("HOST:PORT")
      ->check(ListenAddressOrNone())
      ->default_str("none")
      ->group("Network");
  AddSeconds(app, "--grace-seconds", settings.grace, 0, 3600,
             "Time that running calls may take after SIGTERM")
      ->group("Network");
}

void AddHttpSettings(CLI::App& app, Settings& settings) {
  app.add_option("--http-listen", settings.http_listen,
                 "Address of the metrics and health pages /metrics, /livez, /readyz, without "
                 "authentication; port 0: any free port; none: no pages; if not set: "
                 "127.0.0.1:9464, if that port is free")
      ->type_name("HOST:PORT")
      ->check(ListenAddressOrNone())
      ->capture_default_str()
      ->group("Network");
}

void CheckHttpSettings(const Settings& settings, std::vector<absl::Status>& problems) {
  struct Listener {
    const char* key;
    std::string address;
    const char* origin;
  };
  std::vector<Listener> listeners = {{"listen", settings.server.listen, ""}};
  if (!settings.server.web_listen.empty()) {
    listeners.push_back({"web-listen", settings.server.web_listen, ""});
  }
  if (settings.http_listen.empty()) {
    listeners.push_back({"http-listen", kDefaultHttpListen, " (the default)"});
  } else if (settings.http_listen != "none") {
    listeners.push_back({"http-listen", settings.http_listen, ""});
  }
  for (std::size_t j = 1; j < listeners.size(); ++j) {
    for (std::size_t i = 0; i < j; ++i) {
      const Listener& a = listeners[i];
      const Listener& b = listeners[j];
      if (!Clash(Address(a.address), Address(b.address))) continue;
      problems.push_back(
          core::InvalidArgument("{} and {}: {} and {}{} conflict; set a different port for each",
                                a.key, b.key, a.address, b.address, b.origin));
    }
  }
}

void AddLogSettings(CLI::App& app, Settings& settings) {
  app.add_option("--log-level", settings.log.level,
                 "Minimum level of the lines logged on standard error")
      ->type_name("LEVEL")
      ->check(CLI::IsMember({"debug", "info", "warning", "error", "off"}))
      ->capture_default_str()
      ->group("Log");
  app.add_option_function<std::string>(
         "--log-format",
         [&settings](const std::string& format) {
           settings.log.format = format == "json" ? LogFormat::kJson : LogFormat::kText;
         },
         "Format of the log: text lines, or one JSON object per line")
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"text", "json"}))
      ->default_str("text")
      ->group("Log");
  AddSeconds(app, "--slow-call-seconds", settings.log.slow_call, 0, 3600,
             "Duration from which a call is logged as slow, with a warning; 0: never")
      ->group("Log");
}

}  // namespace motiondb::server
