// The optimal node transition (section IV-A): the node paths that explain an observation, found
// layer by layer down the tree. Safe to call from any thread.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/inference/lattice.h"
#include "core/motion/cancellation.h"
#include "core/motion/matrix.h"

namespace motiondb::core {

class Model;

struct NodePathOptions {
  int layer = 0;  // where to stop; 0 is the bottom layer
  int path_count = 1;
  double transition_floor = 1e-6;  // probability of a transition never seen; 0 forbids it
  int max_candidates = 16;         // kept for each frame and layer; 0 keeps all: exact Viterbi
};

// INVALID_ARGUMENT naming the field if an option is out of range.
absl::Status CheckOptions(const NodePathOptions& options);

// Goes down the tree from the root: the candidates of a frame are the children of those kept in the
// layer above; each is scored by the best path through it (emission and transitions), and the best
// `max_candidates` are kept. Returns the candidates of the layer asked for, not yet pruned, with
// eq. 8 summed over them: over all nodes of the layer where max_candidates is 0. `observation` is
// frames x dimensions, scaled, NaN where missing, with at least one frame. OUT_OF_RANGE for a layer
// that is not there; INVALID_ARGUMENT for more candidates than memory is given for; CANCELLED.
absl::StatusOr<Lattice> DescendTree(const Model& model, const FrameMatrix& observation,
                                    const NodePathOptions& options,
                                    const Cancelled& cancelled = {});

struct PathSearch {
  int layer = 0;
  Lattice lattice;              // the candidates of the layer
  std::vector<NodePath> paths;  // through its global graph, in descending order of probability
};

// The best paths (eq. 7, P(k) uniform). FAILED_PRECONDITION if no path has a probability above 0
// (only with floor 0); INVALID_ARGUMENT for more paths than memory is given for; otherwise as
// DescendTree. Fewer paths are returned where fewer exist.
// O(layers * frames * candidates * (dimensions + candidates)).
absl::StatusOr<PathSearch> FindNodePaths(const Model& model, const FrameMatrix& observation,
                                         const NodePathOptions& options,
                                         const Cancelled& cancelled = {});

// The nodes that the motion may be in at the last frame, summed over all paths, most probable
// first. CANCELLED.
absl::StatusOr<std::vector<NodeState>> LastNodes(const Model& model, const PathSearch& search,
                                                 double transition_floor,
                                                 const Cancelled& cancelled = {});

}  // namespace motiondb::core
