#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "server/security/tls.h"
#include "tests/support/captured_log.h"

namespace motiondb::tests::certificate_end_test {
namespace {

using server::CertificateExpiry;

constexpr std::int64_t kDay = 86'400;
constexpr std::int64_t kNow = 1'800'000'000;  // 2027-01-15 08:00 UTC

auto Lines(const CapturedLog& log) { return std::ranges::count(log.text(), '\n'); }

TEST_CASE("CertificateExpiry: warns from 14 days before expiry, once for each certificate",
          "[security]") {
  const CapturedLog log(spdlog::level::debug);
  std::vector<std::int64_t> reported;
  CertificateExpiry end([&](std::int64_t time_s) { reported.push_back(time_s); });
  const std::int64_t first = kNow + 15 * kDay;
  end.Look("/etc/server.pem", first, kNow);
  end.Look("/etc/server.pem", first, kNow + kDay - 1);
  CHECK(Lines(log) == 0);
  for (int day = 1; day < 16; ++day) end.Look("/etc/server.pem", first, kNow + day * kDay);
  CHECK(Lines(log) == 1);
  CHECK_THAT(log.text(), Catch::Contains("\"level\":\"warning\"") &&
                             Catch::Contains("/etc/server.pem: a certificate expires on "
                                             "2027-01-30 08:00 UTC"));
  // Another file with a short expiry, then one with a long expiry.
  end.Look("/etc/ca.pem", first + 1, kNow + 2 * kDay);
  CHECK(Lines(log) == 2);
  CHECK_THAT(log.text(), Catch::Contains("/etc/ca.pem: a certificate expires on "));
  end.Look("/etc/server.pem", kNow + 300 * kDay, kNow + 2 * kDay);
  CHECK(Lines(log) == 2);
  CHECK(reported == std::vector<std::int64_t>{first, first + 1, kNow + 300 * kDay});
}

TEST_CASE("CertificateExpiry: an expired certificate is logged, too", "[security]") {
  const CapturedLog log(spdlog::level::debug);
  CertificateExpiry end({});
  end.Look("a.pem", kNow - kDay, kNow);
  CHECK(Lines(log) == 1);
}

}  // namespace
}  // namespace motiondb::tests::certificate_end_test
