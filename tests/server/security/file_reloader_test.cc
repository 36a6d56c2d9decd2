#include <atomic>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "server/security/tls.h"
#include "tests/support/captured_log.h"

namespace motiondb::tests::file_reloader_test {
namespace {

using std::chrono::milliseconds;

// Returns the log lines, "level: message", of a watch whose reads have these results.
std::vector<std::string> LogOf(const std::vector<absl::StatusOr<bool>>& results) {
  const CapturedLog log(spdlog::level::info);
  std::atomic<std::size_t> done = 0;
  {
    const server::FileReloader watch(
        "certificates", "server.pem",
        [&] { return done < results.size() ? results[done++] : absl::StatusOr<bool>(false); },
        milliseconds(1));
    while (done < results.size()) std::this_thread::sleep_for(milliseconds(1));
  }
  std::vector<std::string> lines;
  std::istringstream text(log.text());
  for (std::string line; std::getline(text, line);) {
    const auto json = nlohmann::json::parse(line);
    lines.push_back(json["level"].get<std::string>() + ": " + json["message"].get<std::string>());
  }
  return lines;
}

TEST_CASE("FileReloader: logs changes, and each error once", "[security]") {
  const absl::Status missing = absl::InvalidArgumentError("server.pem: No such file");
  const absl::Status other = absl::InvalidArgumentError("server.key: is another's");
  const std::string reloaded = "info: reloaded certificates: file=server.pem";
  const std::string failure =
      "warning: cannot reload certificates; the previous content stays in use: error=";
  CHECK(LogOf({false, true, false, false}) == std::vector{reloaded});
  CHECK(LogOf({missing, missing, other, other, true, missing}) ==
        std::vector{failure + "server.pem: No such file", failure + "server.key: is another's",
                    reloaded, failure + "server.pem: No such file"});
  CHECK(LogOf({missing, false, missing}).size() == 2);
}

TEST_CASE("FileReloader: stops immediately, with any interval", "[security]") {
  bool was_read = false;
  {
    const server::FileReloader watch(
        "certificates", "server.pem",
        [&] {
          was_read = true;
          return absl::StatusOr<bool>(false);
        },
        std::chrono::hours(1));
  }
  CHECK(!was_read);
}

}  // namespace
}  // namespace motiondb::tests::file_reloader_test
