// What every AccessStore must do: the part of TestMotionStore that is about MotionStore::access.
#pragma once

#include "tests/storage/motion_store_conformance.h"

namespace motiondb::tests {

void TestTokens(StoreUnderTest& store);
void TestAudit(StoreUnderTest& store);
void TestAuditOfChanges(StoreUnderTest& store);

}  // namespace motiondb::tests
