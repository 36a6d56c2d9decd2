// Optimal node transition (section IV-A): finds the node paths that explain an observation, layer
// by layer down the tree.
#pragma once

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "core/inference/lattice.h"
#include "core/motion/execution.h"
#include "core/motion/matrix.h"

namespace motiondb::core {

class ClipMask;
class Model;

struct NodePathOptions {
  int layer = 0;  // the layer of the paths; 0: the bottom layer
  int path_count = 1;
  double transition_floor = 1e-6;  // probability of an unseen transition; 0 forbids it
  int max_candidates = 16;         // beam width for each frame and layer; 0: exact Viterbi
  std::shared_ptr<const ClipMask> mask = nullptr;  // clips to use; null: all
};

// INVALID_ARGUMENT, naming the field, if an option is out of range.
absl::Status CheckPathCount(int path_count);
absl::Status CheckTransitionFloor(double transition_floor);
absl::Status CheckOptions(const NodePathOptions& options);

// Descends the tree from the root. The candidates of a frame are the children of those kept in the
// layer above. Each is scored by the best path through it (emission and transitions); the best
// `max_candidates` are kept. Returns the unpruned candidates of the requested layer, with eq. 8
// normalised over them (over all nodes if max_candidates is 0). Nodes without frames of allowed
// clips are no candidates. `observation`: at least one frame, frames x dimensions, scaled, NaN:
// missing. OUT_OF_RANGE for an unknown layer; INVALID_ARGUMENT above the memory limit; CANCELLED.
absl::StatusOr<Lattice> DescendTree(const Model& model, const FrameMatrix& observation,
                                    const NodePathOptions& options,
                                    const Cancelled& cancelled = {});

struct PathSearch {
  int layer = 0;
  Lattice lattice;  // the candidates of the layer
  // Through the global graph of the allowed clips, in descending order of probability.
  std::vector<NodePath> paths;
  std::shared_ptr<const ClipMask> mask = nullptr;
};

// Returns the best paths (eq. 7, uniform P(k)), fewer if fewer exist. FAILED_PRECONDITION if no
// path has a probability above 0 (only with floor 0); INVALID_ARGUMENT above the memory limit;
// otherwise as DescendTree. O(layers * frames * candidates * (dimensions + candidates)).
absl::StatusOr<PathSearch> FindNodePaths(const Model& model, const FrameMatrix& observation,
                                         const NodePathOptions& options,
                                         const Cancelled& cancelled = {});

// Returns the possible nodes at the last frame, with probabilities summed over all paths, most
// probable first. CANCELLED.
absl::StatusOr<std::vector<NodeState>> LastNodes(const Model& model, const PathSearch& search,
                                                 double transition_floor,
                                                 const Cancelled& cancelled = {});

}  // namespace motiondb::core
