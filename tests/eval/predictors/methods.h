// The rows of the prediction tables: the database's methods and their peers.
#pragma once

#include <vector>

#include "core/motion/marker_set.h"
#include "tests/eval/predictors/predictor.h"

namespace motiondb::tests {

std::vector<PredictionMethod> PredictionMethods(const core::MarkerSet& set);

}  // namespace motiondb::tests
