#include "tests/storage/conformance/in_memory_motion_store.h"

#include <catch2/catch.hpp>

#include "core/model/model.h"
#include "tests/storage/conformance/motion_store_conformance.h"

namespace motiondb::tests::in_memory_motion_store_test {
namespace {

class InContainers final : public StoreUnderTest {
 public:
  storage::MotionStore& Get() override { return store_; }

 private:
  InMemoryMotionStore store_{kPutTime};
};

}  // namespace

TEST_CASE("InMemoryMotionStore: conforms", "[storage][conformance]") {
  TestMotionStore([] { return std::make_unique<InContainers>(); });
}

}  // namespace motiondb::tests::in_memory_motion_store_test
