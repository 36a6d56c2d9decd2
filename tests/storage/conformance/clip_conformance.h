// The part of TestMotionStore about clips, their marker set and their skeletons.
#pragma once

#include "tests/storage/conformance/motion_store_conformance.h"

namespace motiondb::tests {

// Returns the record that a store must return for a new clip.
storage::ClipRecord Expected(const storage::NewClip& clip, const std::string& id,
                             const std::string& skeleton_id);

void TestClips(StoreUnderTest& store);
void TestReplacedClips(StoreUnderTest& store);
void TestDerivedClips(StoreUnderTest& store);
void TestMarkerSetOfFirstClip(StoreUnderTest& store);
void TestSkeletons(StoreUnderTest& store);

}  // namespace motiondb::tests
