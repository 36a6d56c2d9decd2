#include <catch2/catch.hpp>
#include <string>
#include <thread>
#include <vector>

#include "server/rpc/call_limits.h"

namespace motiondb::server::call_memory_test {
namespace {

TEST_CASE("CallMemory: a client may reserve half of the budget", "[server][limits]") {
  CallMemory memory(100);
  CallMemory::Reservation first(memory, "a");
  CHECK(first.Resize(40).ok());
  CHECK(first.Resize(50).ok());
  const absl::Status never = first.Resize(51);
  CHECK(absl::IsResourceExhausted(never));
  CHECK(std::string(never.message()).find("send or request less") != std::string::npos);
  CallMemory::Reservation same_client(memory, "a");
  const absl::Status refused = same_client.Resize(1);
  CHECK(absl::IsResourceExhausted(refused));
  CHECK(std::string(refused.message()).find("calls of this client") != std::string::npos);
  CHECK(std::string(refused.message()).find("retry in 1 s") != std::string::npos);
  CallMemory::Reservation other(memory, "b");
  CHECK(other.Resize(50).ok());
  CHECK(memory.reserved() == 100);
}

TEST_CASE("CallMemory: clients share the budget", "[server][limits]") {
  CallMemory memory(100);
  CallMemory::Reservation first(memory, "a");
  CallMemory::Reservation second(memory, "b");
  CHECK(first.Resize(40).ok());
  {
    CallMemory::Reservation third(memory, "c");
    CHECK(second.Resize(40).ok());
    const absl::Status refused = third.Resize(21);
    CHECK(absl::IsResourceExhausted(refused));
    CHECK(std::string(refused.message()).find("all calls") != std::string::npos);
    CHECK(third.Resize(20).ok());
    CHECK(memory.reserved() == 100);
    CHECK(third.Resize(10).ok());
    CHECK(memory.reserved() == 90);
  }
  CHECK(memory.reserved() == 80);
}

TEST_CASE("CallMemory: a reservation moves to the authenticated client", "[server][limits]") {
  CallMemory memory(100);
  CallMemory::Reservation by_address(memory, "address");
  CHECK(by_address.Resize(50).ok());
  by_address.SetClient("token");
  CallMemory::Reservation of_address(memory, "address");
  CHECK(of_address.Resize(50).ok());
  CallMemory::Reservation of_token(memory, "token");
  CHECK_FALSE(of_token.Resize(1).ok());
  CHECK(memory.reserved() == 100);
}

TEST_CASE("CallMemory: concurrent threads never exceed the budget", "[server][limits]") {
  CallMemory memory(100);
  std::vector<std::thread> threads;
  std::vector<std::int64_t> most(4);
  for (std::int64_t& seen : most) {
    threads.emplace_back([&memory, &seen] {
      for (int i = 0; i < 2000; ++i) {
        CallMemory::Reservation reservation(memory, std::to_string(i % 3));
        reservation.Resize(1 + i % 60).IgnoreError();
        seen = std::max(seen, memory.reserved());
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::int64_t seen : most) CHECK(seen <= 100);
  CHECK(memory.reserved() == 0);
}

}  // namespace
}  // namespace motiondb::server::call_memory_test
