#include "server/rpc/message_memory.h"

#include <catch2/catch.hpp>
#include <string>
#include <thread>
#include <vector>

namespace motiondb::server {
namespace {

TEST_CASE("MessageMemory: calls share what there is", "[server][limits]") {
  MessageMemory memory(100);
  MessageMemory::Share first(memory);
  CHECK(first.Hold(40).ok());
  CHECK(first.Hold(60).ok());
  {
    MessageMemory::Share second(memory);
    CHECK(second.Hold(40).ok());
    const absl::Status refused = second.Hold(41);
    CHECK(absl::IsResourceExhausted(refused));
    CHECK(std::string(refused.message()).find("try again") != std::string::npos);
    CHECK(memory.held() == 100);
    CHECK(second.Hold(10).ok());  // less is always taken
    CHECK(memory.held() == 70);
  }
  CHECK(memory.held() == 60);
  const absl::Status never = first.Hold(101);
  CHECK(absl::IsResourceExhausted(never));
  CHECK(std::string(never.message()).find("send or ask for less") != std::string::npos);
  CHECK(memory.held() == 60);
}

TEST_CASE("MessageMemory: many threads never hold more", "[server][limits]") {
  MessageMemory memory(100);
  std::vector<std::thread> threads;
  std::vector<std::int64_t> most(4);
  for (std::int64_t& seen : most) {
    threads.emplace_back([&memory, &seen] {
      for (int i = 0; i < 2000; ++i) {
        MessageMemory::Share share(memory);
        share.Hold(1 + i % 60).IgnoreError();
        seen = std::max(seen, memory.held());
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::int64_t seen : most) CHECK(seen <= 100);
  CHECK(memory.held() == 0);
}

}  // namespace
}  // namespace motiondb::server
