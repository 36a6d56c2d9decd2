#include "core/inference/estimate.h"

#include <algorithm>
#include <utility>

#include "core/inference/observation.h"
#include "core/motion/error.h"

namespace motiondb::core {

absl::StatusOr<Estimation> Estimate(const Model& model, const StateSequence& observation,
                                    const EstimateOptions& options, const Cancelled& cancelled) {
  MOTIONDB_ASSIGN_OR_RETURN(const FrameMatrix scaled, ScaledObservation(model, observation));
  MOTIONDB_ASSIGN_OR_RETURN(PathSearch search,
                            FindNodePaths(model, scaled, options.search, cancelled));
  const Eigen::VectorXd last = LastNodeDistribution(
      search.lattice, model.global_graph(search.layer), options.search.transition_floor);
  const auto& nodes = search.lattice.back().nodes;

  Estimation estimation;
  estimation.layer = search.layer;
  estimation.paths = std::move(search.paths);
  estimation.state.node = estimation.paths.front().nodes.back();
  const auto at = std::lower_bound(nodes.begin(), nodes.end(), estimation.state.node);
  estimation.state.probability = last[at - nodes.begin()];
  MOTIONDB_ASSIGN_OR_RETURN(estimation.filled,
                            FillMissing(model, observation, scaled, search.layer,
                                        estimation.paths.front().nodes, options.fill, cancelled));
  return estimation;
}

}  // namespace motiondb::core
