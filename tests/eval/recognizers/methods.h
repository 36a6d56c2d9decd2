// The rows of the recognition tables: the database's methods and their peers.
#pragma once

#include <vector>

#include "core/motion/marker_set.h"
#include "tests/eval/recognizers/recognizer.h"

namespace motiondb::tests {

// `set` is the marker set of the observations.
std::vector<RecognitionMethod> RecognitionMethods(const core::MarkerSet& set);

}  // namespace motiondb::tests
