// Tests of the AccessStore contract: a part of TestMotionStore.
#pragma once

#include "tests/storage/conformance/motion_store_conformance.h"

namespace motiondb::tests {

void TestTokens(StoreUnderTest& store);
void TestAudit(StoreUnderTest& store);
void TestAuditOfChanges(StoreUnderTest& store);

}  // namespace motiondb::tests
