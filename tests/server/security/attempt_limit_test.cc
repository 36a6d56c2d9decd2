#include "server/security/attempt_limit.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <string>

namespace motiondb::tests::attempt_limit_test {
namespace {

using server::AttemptLimit;
using std::chrono::milliseconds;

TEST_CASE("AttemptLimit: a source above the limit waits until its window ends", "[security]") {
  AttemptLimit limit(3, milliseconds(1000));
  const AttemptLimit::Clock::time_point start{};
  CHECK(limit.Count("a", start));
  CHECK(limit.Count("a", start + milliseconds(100)));
  CHECK(limit.Wait("a", start + milliseconds(100)) == milliseconds(0));
  CHECK(limit.Count("a", start + milliseconds(200)));
  CHECK(limit.Wait("a", start + milliseconds(300)) == milliseconds(700));
  CHECK(!limit.Count("a", start + milliseconds(400)));
  CHECK(limit.Wait("b", start + milliseconds(400)) == milliseconds(0));
  CHECK(limit.Wait("a", start + milliseconds(1000)) == milliseconds(0));
  CHECK(limit.Count("a", start + milliseconds(1000)));
}

TEST_CASE("AttemptLimit: memory is bounded, and the latest sources are kept", "[security]") {
  AttemptLimit limit(1, milliseconds(1000), 100);
  const AttemptLimit::Clock::time_point start{};
  for (int i = 0; i < 5000; ++i) limit.Count(std::to_string(i), start + milliseconds(i) / 10);
  CHECK(limit.size() <= 100);
  CHECK(limit.Wait("4999", start + milliseconds(500)) > milliseconds(0));
}

TEST_CASE("AttemptLimit: an IPv6 network is one source", "[security]") {
  CHECK(server::AttemptSource("10.1.2.3") == "10.1.2.3");
  CHECK(server::AttemptSource("2001:db8:1:2:3:4:5:6") == server::AttemptSource("2001:db8:1:2::9"));
  CHECK(server::AttemptSource("2001:db8:1:2::9") != server::AttemptSource("2001:db8:1:3::9"));
  CHECK(server::AttemptSource("::ffff:10.1.2.3") != server::AttemptSource("::ffff:10.1.2.4"));
  CHECK(server::AttemptSource("unix") == "unix");
}

}  // namespace
}  // namespace motiondb::tests::attempt_limit_test
