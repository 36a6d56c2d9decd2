#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
#include <cstdlib>

namespace motiondb::tests {
namespace {

// Eigen's Random uses the generator of the process. Seeding makes test cases independent of their
// order.
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
