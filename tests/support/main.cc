#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
#include <cstdlib>

namespace motiondb::tests {
namespace {

// Eigen's Random draws from the generator of the process: each test case has the same numbers,
// whichever ran before it.
struct SeedEachTestCase : Catch::TestEventListenerBase {
  using TestEventListenerBase::TestEventListenerBase;
  void testCaseStarting(const Catch::TestCaseInfo& test) override {
    TestEventListenerBase::testCaseStarting(test);
    std::srand(1);
  }
};
CATCH_REGISTER_LISTENER(SeedEachTestCase)

}  // namespace
}  // namespace motiondb::tests
