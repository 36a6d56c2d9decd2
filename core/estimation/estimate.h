// What state is it in? (sections IV-A, V-A). Safe to call from any thread.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/estimation/missing_markers.h"
#include "core/inference/node_path.h"
#include "core/motion/cancellation.h"
#include "core/motion/states.h"

namespace motiondb::core {

class Model;

struct EstimateOptions {
  NodePathOptions search;
  Fill fill = Fill::kLastFrame;
};

struct Estimation {
  int layer = 0;
  std::vector<NodePath> paths;  // best first
  // Last node of the best path, with its probability given the whole observation.
  NodeState state;
  std::vector<FilledFrame> filled;  // frames that lacked markers, as far as asked for
};

// The node paths of an observation (not scaled; the model's markers and frame rate) in the global
// graph, and where its missing markers are. INVALID_ARGUMENT for settings out of range or an
// observation that does not fit; FAILED_PRECONDITION if the strict rule (floor 0) allows no path;
// CANCELLED.
absl::StatusOr<Estimation> Estimate(const Model& model, const StateSequence& observation,
                                    const EstimateOptions& options,
                                    const Cancelled& cancelled = {});

}  // namespace motiondb::core
