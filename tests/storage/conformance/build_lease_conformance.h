// The parts of TestMotionStore about what several servers need: build leases, the conditions for
// storing a model, models read from the one that they extend, and the states of databases.
#pragma once

#include "tests/storage/conformance/motion_store_conformance.h"

namespace motiondb::tests {

void TestBuildLeases(StoreUnderTest& store);
// Several builders do random things; each result must be that of a simple model.
void TestRandomBuilders(StoreUnderTest& store, unsigned seed, int steps);
void TestReadExtension(StoreUnderTest& store);
void TestDatabaseStates(StoreUnderTest& store);

}  // namespace motiondb::tests
