#include "server/settings/groups.h"
#include "server/settings/options.h"

namespace motiondb::server {
namespace {

// An address, or the word that means that there is none.
CLI::Validator ListenAddressOrNone() {
  return CLI::Validator(
      [address = ListenAddress()](std::string& text) {
        return text.empty() || text == "none" ? std::string() : address(text);
      },
      "");
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

}  // namespace motiondb::server
