// The whole readable content of a store as text. Two stores are equal if their dumps are equal.
#pragma once

#include <string>

#include "storage/motion_store.h"

namespace motiondb::tests {

// Requires that everything can be read; models may be missing.
std::string Dump(storage::MotionStore& store);

// The same of one database, without its name and its operations.
std::string DumpDatabase(storage::MotionStore& store, const std::string& database);

// Returns the findings of a verification, one per line; empty if nothing is corrupt.
std::string Findings(storage::MotionStore& store);

}  // namespace motiondb::tests
