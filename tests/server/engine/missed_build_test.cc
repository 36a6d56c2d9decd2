#include <catch2/catch.hpp>

#include "server/engine/build_lease.h"

namespace motiondb::server::missed_build_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using storage::OperationState;

class Looks {
 public:
  // Looks once a second. Returns how many seconds after the first look the check is due; -1: it is
  // not due within 20 minutes.
  int SecondsUntilDue(MissedBuild& missed) {
    for (int second = 0; second < 1200; ++second) {
      if (Look(missed, /*is_changed=*/false)) return second;
    }
    return -1;
  }
  bool Look(MissedBuild& missed, bool is_changed, bool is_busy = false) {
    now_ += seconds(1);
    return missed.IsDue(now_, is_changed, is_busy);
  }

 private:
  Executor::Clock::time_point now_{seconds(1000)};
};

storage::OperationRecord Operation(const std::string& id, OperationState state) {
  return {.id = id, .database = "d", .state = state};
}

TEST_CASE("MissedBuild: checks once after changes, some seconds later", "[server]") {
  Looks looks;
  MissedBuild missed(milliseconds(0));
  MissedBuild later(milliseconds(1500));
  CHECK(looks.SecondsUntilDue(missed) == -1);
  CHECK_FALSE(looks.Look(missed, /*is_changed=*/true));
  CHECK_FALSE(looks.Look(missed, /*is_changed=*/true));
  CHECK(looks.SecondsUntilDue(missed) == 2);
  CHECK(looks.SecondsUntilDue(missed) == -1);
  looks.Look(later, /*is_changed=*/true);
  CHECK(looks.SecondsUntilDue(later) == 4);
}

TEST_CASE("MissedBuild: waits while operations run", "[server]") {
  Looks looks;
  MissedBuild missed(milliseconds(0));
  looks.Look(missed, /*is_changed=*/true);
  for (int second = 0; second < 60; ++second) {
    CHECK_FALSE(looks.Look(missed, /*is_changed=*/false, /*is_busy=*/true));
  }
  CHECK(looks.SecondsUntilDue(missed) == 2);
}

TEST_CASE("MissedBuild: checks again if the store could not be read", "[server]") {
  Looks looks;
  MissedBuild missed(milliseconds(0));
  looks.Look(missed, /*is_changed=*/true);
  CHECK(looks.SecondsUntilDue(missed) == 2);
  missed.Checked(absl::UnavailableError("the store cannot be reached"));
  CHECK(looks.SecondsUntilDue(missed) == 0);
}

TEST_CASE("MissedBuild: requests rarely if the model stays out of date", "[server]") {
  Looks looks;
  MissedBuild missed(milliseconds(0));
  const auto wait = [&] {
    looks.Look(missed, /*is_changed=*/true);
    return looks.SecondsUntilDue(missed);
  };
  for (const int expected : {2, 5, 11, 23, 47, 95, 191, 383, 599, 599}) {
    CHECK(wait() == expected);
    missed.Checked(true);
  }
  wait();
  missed.Checked(false);
  CHECK(wait() == 2);
}

TEST_CASE("MissedBuild: a cancelled or failed build waits for the next change", "[server]") {
  MissedBuild missed(milliseconds(0));
  CHECK(missed.MayRequest(nullptr, 1));
  const auto succeeded = Operation("a", OperationState::kSucceeded);
  CHECK(missed.MayRequest(&succeeded, 2));
  const auto stopped =
      Operation("b", GENERATE(OperationState::kCancelled, OperationState::kFailed));
  CHECK_FALSE(missed.MayRequest(&stopped, 3));
  CHECK_FALSE(missed.MayRequest(&stopped, 3));
  CHECK(missed.MayRequest(&stopped, 4));
  const auto next = Operation("c", OperationState::kCancelled);
  CHECK_FALSE(missed.MayRequest(&next, 4));
}

TEST_CASE("MissedBuild: an operation that runs is awaited", "[server]") {
  Looks looks;
  MissedBuild missed(milliseconds(0));
  looks.Look(missed, /*is_changed=*/true);
  CHECK(looks.SecondsUntilDue(missed) == 2);
  const auto running = Operation("a", OperationState::kRunning);
  CHECK_FALSE(missed.MayRequest(&running, 1));
  CHECK(looks.SecondsUntilDue(missed) == 0);
}

}  // namespace
}  // namespace motiondb::server::missed_build_test
