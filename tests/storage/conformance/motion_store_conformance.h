// Conformance tests of the MotionStore contract. The test of an implementation calls
// TestMotionStore in its own TEST_CASE.
#pragma once

#include <functional>
#include <memory>

#include "storage/motion_store.h"

namespace motiondb::tests {

// A store, initially empty. Get may reopen the store at each call, so tests must not keep the
// reference.
class StoreUnderTest {
 public:
  virtual ~StoreUnderTest() = default;
  virtual storage::MotionStore& Get() = 0;
  storage::MotionStore* operator->() { return &Get(); }
};

// `make` returns a new store, whose clock for the creation time of models always shows kPutTime.
inline constexpr std::int64_t kPutTime = 1'700'000'000'000'099;
void TestMotionStore(const std::function<std::unique_ptr<StoreUnderTest>()>& make);

}  // namespace motiondb::tests
