// The part of TestMotionStore that is about models and what extends them.
#pragma once

#include "tests/storage/motion_store_conformance.h"

namespace motiondb::tests {

void TestModels(StoreUnderTest& store);

}  // namespace motiondb::tests
