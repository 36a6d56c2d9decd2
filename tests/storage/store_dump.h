// The whole readable content of a store as text. Two stores are equal if their dumps are equal.
#pragma once

#include <string>

#include "storage/motion_store.h"

namespace motiondb::tests {

// Requires that everything can be read; models may be missing.
std::string Dump(storage::MotionStore& store);

// Returns the findings of a verification, one per line; empty if nothing is corrupt.
std::string Findings(storage::MotionStore& store);

}  // namespace motiondb::tests
