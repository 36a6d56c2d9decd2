// What every MotionStore must do, as tests on the interface alone. An implementation's test calls
// TestMotionStore in a TEST_CASE of its own.
#pragma once

#include <functional>
#include <memory>

#include "storage/motion_store.h"

namespace motiondb::tests {

// A store, empty at first. Where it is kept on a disk, each use may be on one that was just opened
// anew: the tests keep no pointer to it.
class StoreUnderTest {
 public:
  virtual ~StoreUnderTest() = default;
  virtual storage::MotionStore& Get() = 0;
  storage::MotionStore* operator->() { return &Get(); }
};

// `make` gives a new store each time. It puts models at the time kPutTime.
inline constexpr std::int64_t kPutTime = 1'700'000'000'000'099;
void TestMotionStore(const std::function<std::unique_ptr<StoreUnderTest>()>& make);

}  // namespace motiondb::tests
