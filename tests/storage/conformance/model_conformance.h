// The part of TestMotionStore about models and extensions.
#pragma once

#include "tests/storage/conformance/motion_store_conformance.h"

namespace motiondb::tests {

void TestModels(StoreUnderTest& store);

}  // namespace motiondb::tests
