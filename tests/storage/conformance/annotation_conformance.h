// The part of TestMotionStore about annotations: segments, edits, changes and text search.
#pragma once

#include <string>

#include "storage/motion_store.h"
#include "tests/storage/conformance/motion_store_conformance.h"

namespace motiondb::tests {

// Returns everything that a caller sees of the annotations of a record, as one line.
std::string Describe(const storage::ClipRecord& clip);
std::string Describe(const storage::SegmentRecord& segment);

// Returns the annotations of all clips of a database, and their segments.
std::string DumpAnnotations(storage::MotionStore& store, const std::string& database);

void TestSegments(StoreUnderTest& store);
void TestLabels(StoreUnderTest& store);
void TestSegmentsOfNewClips(StoreUnderTest& store);
void TestEdits(StoreUnderTest& store);
void TestUndo(StoreUnderTest& store);
void TestKeptAnnotations(StoreUnderTest& store);
void TestTextSearch(StoreUnderTest& store);
void TestChanges(StoreUnderTest& store);

// Compares random edits and undos with a simple model of a database.
void TestRandomEdits(StoreUnderTest& store, unsigned seed, int steps);
// After random changes, any replica that applies pages of changes, from any revision on, has the
// present state.
void TestReplicas(StoreUnderTest& store, unsigned seed, int steps);

}  // namespace motiondb::tests
