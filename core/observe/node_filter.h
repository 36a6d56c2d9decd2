// The current node of a stream, given all frames so far: the forward algorithm on the candidate
// nodes of each frame. Not thread-safe.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/graph/transition_graph.h"
#include "core/inference/lattice.h"

namespace motiondb::core {

class ClipMask;
class Model;

// alpha_t(j) = e_t(j) sum_i alpha_{t-1}(i) P(i -> j), normalised to sum 1. The candidates j are
// found as by DescendTree (core/inference/node_path.h), but the beam is pruned by the frame's own
// emission e only. So each frame is processed once, in O(layers * candidates * dimensions +
// candidates^2). With an unlimited beam the result equals LastNodes of FindNodePaths over the whole
// stream. If no transition is possible, the filter restarts.
class NodeFilter {
 public:
  // `layer` is one of the model's layers; `mask`: the clips to use, null: all; 0 candidates: no
  // limit. The model and the mask must outlive this object.
  NodeFilter(const Model& model, int layer, double transition_floor, const ClipMask* mask = nullptr,
             int max_candidates = 16);

  // Adds the next frame: its scaled state (dimensions), NaN: missing. Does not allocate once the
  // vectors have grown.
  void Advance(const float* state);
  // Returns the most probable node (ties: the first) if this were the next frame, without adding
  // it.
  NodeState Peek(const float* state);
  // Forgets all frames.
  void Restart() { now_.nodes.clear(); }

  int layer() const { return layer_; }
  // Distribution after the frames so far: nodes ascending, probabilities sum to 1.
  const std::vector<std::int32_t>& nodes() const { return now_.nodes; }
  const std::vector<double>& probability() const { return now_.probability; }

 private:
  struct Distribution {
    std::vector<std::int32_t> nodes;
    std::vector<double> probability;
  };
  // Nodes with the log density of the frame in each.
  struct Candidates {
    std::vector<std::int32_t> nodes;
    std::vector<double> log_density;
  };

  void Step(const float* state, Distribution& next);
  void Descend(const float* state);
  void KeepBest();
  // Candidates of a frame without any marker: successors in the graph.
  void Follow();
  // Computes the probability that arrives at each candidate from the current nodes.
  void Arrive();

  const Model& model_;
  const int layer_;
  const double floor_;
  const ClipMask* const mask_;
  const TransitionGraph& graph_;
  const int max_candidates_;
  Distribution now_;
  Distribution next_;
  Candidates candidates_;
  Candidates above_;
  std::vector<double> densities_;
  std::vector<std::pair<double, std::int32_t>> leads_;
  std::vector<double> arriving_;  // probability that arrives at each candidate
};

}  // namespace motiondb::core
