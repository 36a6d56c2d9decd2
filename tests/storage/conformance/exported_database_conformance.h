// The part of TestMotionStore about the export and import of single databases.
#pragma once

#include "tests/storage/conformance/motion_store_conformance.h"

namespace motiondb::tests {

// Creates a database with every kind of content: models, an extension, a deleted clip of the model,
// a replaced clip, segments, edits, tombstones, an operation.
void FillWithEverything(storage::MotionStore& store, const std::string& database);

// Without effect if the store has no maintenance because it is in memory.
void TestExportedDatabases(StoreUnderTest& store);

}  // namespace motiondb::tests
