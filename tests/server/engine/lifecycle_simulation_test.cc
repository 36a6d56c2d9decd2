// The model lifecycle keeps its guarantees under random events, crashes and stops.
#include "tests/server/engine/lifecycle_simulation.h"

#include <catch2/catch.hpp>

namespace motiondb::tests::lifecycle_simulation_test {
namespace {

TEST_CASE("Lifecycle: keeps its guarantees under random events", "[server][lifecycle]") {
  BuildStatistics statistics;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    CAPTURE(seed);
    LifecycleSimulation simulation(seed);
    for (int step = 0; step < 60; ++step) simulation.Step();
    simulation.CheckEnd();
    statistics += simulation.statistics();
    simulation.CheckStop();
  }
  // Otherwise the events were too dense or too rare to test these cases.
  CHECK(statistics.builds > 40);
  CHECK(statistics.borrowing > 100);
  CHECK(statistics.cancelled_borrowing > 0);
  CHECK(statistics.extended_borrowing > 0);
  CHECK(statistics.evictions > 0);
}

TEST_CASE("Lifecycle: a crash at any moment loses no acknowledged change", "[server][lifecycle]") {
  BuildStatistics statistics;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    LifecycleSimulation simulation(seed);
    for (int life = 0; life < 3; ++life) {
      for (int step = 0; step < 15; ++step) simulation.Step();
      simulation.CrashAndRestart();
    }
    simulation.CheckEnd();
    statistics += simulation.statistics();
  }
  CHECK(statistics.borrowing > 100);
}

TEST_CASE("Lifecycle: can drain or be deleted at any moment of a build", "[server][lifecycle]") {
  int drains = 0;
  int deletions = 0;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    CAPTURE(seed);
    LifecycleSimulation drained(seed);
    for (int step = 0; step < 10; ++step) drained.Step();
    drained.CheckEnd();
    drains += drained.CheckDrainInBuild();
    LifecycleSimulation deleted(seed);
    for (int step = 0; step < 10; ++step) deleted.Step();
    deleted.CheckEnd();
    deletions += deleted.CheckDeletionInBuild();
  }
  CHECK(drains > 5);
  CHECK(deletions > 5);
}

}  // namespace
}  // namespace motiondb::tests::lifecycle_simulation_test
