#include "client/cli/number_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace motiondb::client {

std::optional<std::vector<double>> ParseNumbers(const std::string& text) {
  std::vector<double> numbers;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t comma = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, comma - begin);
    char* end = nullptr;
    const double number = std::strtod(part.c_str(), &end);
    if (part.empty() || *end != '\0' || !std::isfinite(number)) return std::nullopt;
    numbers.push_back(number);
    begin = comma + 1;
  }
  return numbers;
}

CLI::Validator NumberList(const char* expected, bool (*fits)(const std::vector<double>&)) {
  return CLI::Validator(
      [expected, fits](const std::string& text) {
        const auto numbers = ParseNumbers(text);
        return numbers && fits(*numbers) ? "" : fmt::format("expected {}, got {}", expected, text);
      },
      "");
}

}  // namespace motiondb::client
