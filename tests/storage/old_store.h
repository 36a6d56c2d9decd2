// The stores in tests/storage/old_stores, each made by the programs of its version.
#pragma once

#include <string>

namespace motiondb::tests {

// The file's bytes.
std::string OldStore(int version);

}  // namespace motiondb::tests
