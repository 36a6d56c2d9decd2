#include "core/estimation/estimate.h"

#include <algorithm>
#include <utility>

#include "core/inference/observation.h"
#include "core/model/model.h"
#include "core/motion/error.h"

namespace motiondb::core {

absl::StatusOr<Estimation> Estimate(const Model& model, const StateSequence& observation,
                                    const EstimateOptions& options, const Cancelled& cancelled) {
  MOTIONDB_ASSIGN_OR_RETURN(const FrameMatrix scaled, ScaledObservation(model, observation));
  MOTIONDB_ASSIGN_OR_RETURN(PathSearch search,
                            FindNodePaths(model, scaled, options.search, cancelled));
  MOTIONDB_ASSIGN_OR_RETURN(const auto last,
                            LastNodes(model, search, options.search.transition_floor, cancelled));

  Estimation estimation;
  estimation.layer = search.layer;
  estimation.paths = std::move(search.paths);
  const int node = estimation.paths.front().nodes.back();
  const auto found = std::ranges::find(last, node, &NodeState::node);
  estimation.state = {node, found == last.end() ? 0 : found->probability};
  MOTIONDB_ASSIGN_OR_RETURN(estimation.filled,
                            FillMissing(model, observation, scaled, search.layer,
                                        estimation.paths.front().nodes, options.fill, cancelled));
  return estimation;
}

}  // namespace motiondb::core
