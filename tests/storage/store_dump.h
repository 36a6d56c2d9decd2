// All that can be read of a store, as text: two stores are the same where their dumps are.
#pragma once

#include <string>

#include "storage/motion_store.h"

namespace motiondb::tests {

// REQUIREs that everything can be read, but for a model, which need not be there.
std::string Dump(storage::MotionStore& store);

// What its verification finds, one a line; empty where nothing is damaged.
std::string Findings(storage::MotionStore& store);

}  // namespace motiondb::tests
