// Counting calls: of one client and in all.
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

TEST_CASE("CallLimits: a client has its share, all together theirs", "[server][limits]") {
  CallLimits limits(kFew);
  auto first = limits.Enter(RequestClass::kHeavy, "a");
  auto second = limits.Enter(RequestClass::kHeavy, "a");
  REQUIRE(first.ok());
  REQUIRE(second.ok());
  const auto own = limits.Enter(RequestClass::kHeavy, "a");
  CHECK(absl::IsResourceExhausted(own.status()));
  CHECK(std::string(own.status().message()) ==
        "2 heavy calls are under way for this client, as many as there may be "
        "(a quarter of --max-heavy-calls): try again in 1 s, or when one has ended");
  CHECK(own.status().GetPayload("type.googleapis.com/google.rpc.RetryInfo").has_value());

  auto third = limits.Enter(RequestClass::kHeavy, "b");
  CHECK(third.ok());
  const auto all = limits.Enter(RequestClass::kHeavy, "c");
  CHECK(std::string(all.status().message()).find("3 heavy calls are under way in all") == 0);

  // Kinds are counted apart, and a place that is given up is free.
  CHECK(limits.Enter(RequestClass::kLight, "a").ok());
  first = absl::CancelledError("over");
  CHECK(limits.Enter(RequestClass::kHeavy, "a").ok());
}

TEST_CASE("CallLimits: a place moves with its slot and is given up once", "[server][limits]") {
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

TEST_CASE("CallLimits: threads never have more than there may be", "[server][limits]") {
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
