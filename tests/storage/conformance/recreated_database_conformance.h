// The part of TestMotionStore about a database that is deleted and created again under its name.
#pragma once

#include "tests/storage/conformance/motion_store_conformance.h"

namespace motiondb::tests {

void TestRecreatedDatabase(StoreUnderTest& store);

}  // namespace motiondb::tests
