// Limits on calls of one client and in total.
#include "server/rpc/call_limits.h"

#include <catch2/catch.hpp>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace motiondb::server::call_limits_test {
namespace {

constexpr CallLimitOptions kFew{.calls = {4, 4}, .heavy = {3, 2}, .streams = {1, 1}};

TEST_CASE("CallLimits: limits for one client and in total", "[server][limits]") {
  CallLimits limits(kFew);
  auto first = limits.Enter(RequestClass::kHeavy, "a");
  auto second = limits.Enter(RequestClass::kHeavy, "a");
  REQUIRE(first.ok());
  REQUIRE(second.ok());
  const auto client_error = limits.Enter(RequestClass::kHeavy, "a");
  CHECK(absl::IsResourceExhausted(client_error.status()));
  CHECK(std::string(client_error.status().message()) ==
        "too many heavy calls: 2 in flight for this client, the maximum (a quarter of "
        "--max-heavy-calls); retry in 1 s or when one has ended");
  CHECK(client_error.status().GetPayload("type.googleapis.com/google.rpc.RetryInfo").has_value());

  auto third = limits.Enter(RequestClass::kHeavy, "b");
  CHECK(third.ok());
  const auto total_error = limits.Enter(RequestClass::kHeavy, "c");
  CHECK(std::string(total_error.status().message())
            .find("too many heavy calls: 3 in flight in total") == 0);

  // Classes are counted separately, and a released slot is free.
  CHECK(limits.Enter(RequestClass::kLight, "a").ok());
  first = absl::CancelledError("over");
  CHECK(limits.Enter(RequestClass::kHeavy, "a").ok());
}

TEST_CASE("CallLimits: a moved slot is released once", "[server][limits]") {
  CallLimits limits(kFew);
  {
    CallLimits::Slot slot = *limits.Enter(RequestClass::kStream, "a");
    CallLimits::Slot moved = std::move(slot);
    CHECK(limits.open(RequestClass::kStream) == 1);
    slot = std::move(moved);
    CHECK(limits.open(RequestClass::kStream) == 1);
  }
  CHECK(limits.open(RequestClass::kStream) == 0);
}

TEST_CASE("CallLimits: concurrent threads never exceed the limit", "[server][limits]") {
  CallLimits limits(kFew);
  std::vector<std::thread> threads;
  std::vector<int> most(4, 0);
  for (std::size_t t = 0; t < most.size(); ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 2000; ++i) {
        const auto slot = limits.Enter(RequestClass::kHeavy, std::to_string(t % 2));
        if (slot.ok()) most[t] = std::max(most[t], limits.open(RequestClass::kHeavy));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const int seen : most) CHECK(seen <= 3);
  CHECK(limits.open(RequestClass::kHeavy) == 0);
}

}  // namespace
}  // namespace motiondb::server::call_limits_test
