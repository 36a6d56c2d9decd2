// The rows of the tables of recognition: the database's methods and their peers.
#pragma once

#include <vector>

#include "core/motion/marker_set.h"
#include "tests/eval/recognizers/recognizer.h"

namespace motiondb::tests {

// `set` is what observations are told on.
std::vector<RecognitionMethod> RecognitionMethods(const core::MarkerSet& set);

}  // namespace motiondb::tests
