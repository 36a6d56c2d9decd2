#include "server/settings/groups.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace motiondb::server {
namespace {

bool IsPort(const std::string& text) {
  unsigned port = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, port);
  return error == std::errc() && rest == end && port <= 65535;
}

bool IsHost(const std::string& text) {
  if (text.empty()) return false;
  // An IPv6 address needs brackets: its colons are ambiguous with the colon before the port.
  const bool bracketed = text.front() == '[' && text.back() == ']' && text.size() > 2;
  return bracketed || text.find_first_of(":[]") == std::string::npos;
}

// CLI::Range accepts "nan", which is neither below nor above its bounds.
const CLI::Validator Number(
    [](std::string& text) {
      double value = 0;
      return CLI::detail::lexical_cast(text, value) && std::isfinite(value)
                 ? std::string()
                 : fmt::format("expected a number, got '{}'", text);
    },
    "");

}  // namespace

CLI::Validator WholeNumber() {
  const auto check = [](std::string& text) {
    // CLI11 reads 010 as octal 8. A number that is too large fails the range check.
    const std::size_t sign = text.starts_with('-') ? 1 : 0;
    const std::string digits = text.substr(sign);
    if (digits.empty() || digits.find_first_not_of("0123456789") != std::string::npos) {
      return fmt::format("expected a whole number, got '{}'", text);
    }
    const bool octal = digits.size() > 1 && digits.front() == '0';
    return octal ? fmt::format("'{}' begins with 0; omit the leading 0", text) : std::string();
  };
  return CLI::Validator(check, "");
}

CLI::Option* AddSeconds(CLI::App& app, const std::string& name, std::chrono::milliseconds& time,
                        double min, double max, const std::string& description) {
  const auto set = [&time](double seconds) {
    time = std::chrono::milliseconds(std::llround(seconds * 1000));
  };
  return app.add_option_function<double>(name, set, description)
      ->type_name("SECONDS")
      ->check(Number)
      ->check(CLI::Range(min, max))
      ->default_str(fmt::format("{:g}", static_cast<double>(time.count()) / 1000));
}

CLI::Validator ListenAddress() {
  const auto check = [](std::string& address) {
    const std::size_t colon = address.rfind(':');
    if (colon != std::string::npos && IsHost(address.substr(0, colon)) &&
        IsPort(address.substr(colon + 1))) {
      return std::string();
    }
    return fmt::format("expected HOST:PORT with a port from 0 to 65535, got '{}'", address);
  };
  return CLI::Validator(check, "");
}

}  // namespace motiondb::server
