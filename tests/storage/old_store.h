// The stores of former versions in tests/storage/old_stores.
#pragma once

#include <string>

namespace motiondb::tests {

// Returns the bytes of the store file.
std::string OldStore(int version);

}  // namespace motiondb::tests
