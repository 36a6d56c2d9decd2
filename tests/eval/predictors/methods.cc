#include "tests/eval/predictors/methods.h"

#include "tests/eval/peers/nearest_exemplar.h"
#include "tests/eval/peers/simple_motion.h"
#include "tests/eval/predictors/database_predictor.h"

namespace motiondb::tests {

std::vector<PredictionMethod> PredictionMethods(const core::MarkerSet& set) {
  std::vector<PredictionMethod> methods = DatabasePredictionMethods(set);
  methods.push_back({"nearest exemplars", [] { return std::make_unique<NearestExemplar>(); }});
  methods.push_back({"constant velocity", [] { return std::make_unique<SimpleMotion>(1); }});
  methods.push_back({"zero velocity", [] { return std::make_unique<SimpleMotion>(0); }});
  return methods;
}

}  // namespace motiondb::tests
