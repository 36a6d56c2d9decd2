#include <atomic>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "server/security/tls.h"
#include "tests/support/captured_log.h"

namespace motiondb::tests::file_watch_test {
namespace {

using std::chrono::milliseconds;

// "level: message" of each line that a watch logs whose looks come to these results.
std::vector<std::string> LogOf(const std::vector<absl::StatusOr<bool>>& looks) {
  const CapturedLog log(spdlog::level::info);
  std::atomic<std::size_t> done = 0;
  {
    const server::FileWatch watch(
        "certificates", "server.pem",
        [&] { return done < looks.size() ? looks[done++] : absl::StatusOr<bool>(false); },
        milliseconds(1));
    while (done < looks.size()) std::this_thread::sleep_for(milliseconds(1));
  }
  std::vector<std::string> lines;
  std::istringstream text(log.text());
  for (std::string line; std::getline(text, line);) {
    const auto json = nlohmann::json::parse(line);
    lines.push_back(json["level"].get<std::string>() + ": " + json["message"].get<std::string>());
  }
  return lines;
}

TEST_CASE("FileWatch: tells of what is new, and once of each fault", "[security]") {
  const absl::Status gone = absl::InvalidArgumentError("server.pem: No such file");
  const absl::Status other = absl::InvalidArgumentError("server.key: is another's");
  const std::string taken = "info: new certificates, from server.pem";
  const std::string kept = "warning: no new certificates, what was read before stays in force: ";
  CHECK(LogOf({false, true, false, false}) == std::vector{taken});
  CHECK(LogOf({gone, gone, other, other, true, gone}) ==
        std::vector{kept + "server.pem: No such file", kept + "server.key: is another's", taken,
                    kept + "server.pem: No such file"});
  CHECK(LogOf({gone, false, gone}).size() == 2);
}

TEST_CASE("FileWatch: ends at once, however seldom it looks", "[security]") {
  bool looked = false;
  {
    const server::FileWatch watch(
        "certificates", "server.pem",
        [&] {
          looked = true;
          return absl::StatusOr<bool>(false);
        },
        std::chrono::hours(1));
  }
  CHECK(!looked);
}

}  // namespace
}  // namespace motiondb::tests::file_watch_test
