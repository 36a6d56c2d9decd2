// Clips of an older representation in the database "db" of an engine, and what becomes of them.
#pragma once

#include <cstddef>
#include <string>

#include "storage/records.h"
#include "tests/support/test_engine.h"

namespace motiondb::tests {

// A walk of 60 frames as a BVH file. The hips are displaced in `glitch_frames` frames from the 20th
// on.
std::string WalkBvh(double phase, int glitch_frames = 0);

// Ingests NAME.bvh with label NAME and returns the id of the operation.
std::string IngestBvh(TestEngine& engine, const std::string& name, const std::string& bvh);

// Runs a script on the store of a stopped engine (corrupt_store.h).
std::string RunSql(const TestEngine& engine, const std::string& script);

// Fills the database of an engine, then stops it. Leaves the store of a server without glitch
// detection: clips clean (no glitch), short (repairable) and long (not repairable), with a model.
void FillWithOutdated(TestEngine& engine);

// Waits for all operations. Returns the newest.
storage::OperationRecord AwaitOperations(TestEngine& engine);

std::size_t OperationCount(TestEngine& engine);

// REQUIREs the clip.
storage::ClipRecord StoredClip(TestEngine& engine, const std::string& id);

// Returns the ids of the clips of the current model, each followed by a space, or "none".
std::string ModelClipIds(TestEngine& engine);

// Returns whether the current model has the stored states of each of its clips.
bool ModelHasStoredStates(TestEngine& engine);

// Returns whether the stored model has all stored clips, with their current states.
bool ModelIsUpToDate(TestEngine& engine);

}  // namespace motiondb::tests
