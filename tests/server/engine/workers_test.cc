#include "server/engine/workers.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <catch2/catch.hpp>
#include <future>

namespace motiondb::server {
namespace {

int Niceness() { return getpriority(PRIO_PROCESS, static_cast<id_t>(gettid())); }

TEST_CASE("Workers: threads that build are nicer than those that answer", "[server]") {
  EngineOptions options;
  options.query_threads = 1;
  options.build_threads = 3;
  const int own = Niceness();
  Workers workers(options);
  for (int i = 0; i < 12; ++i) {
    std::promise<int> building, answering;
    boost::asio::post(workers.build_executor(), [&] { building.set_value(Niceness()); });
    workers.Post([&] { answering.set_value(Niceness()); });
    REQUIRE(building.get_future().get() == std::min(own + 10, 19));
    REQUIRE(answering.get_future().get() == own);
  }
}

}  // namespace
}  // namespace motiondb::server
