// Where in the tree a motion is now, given every frame so far: the forward algorithm on the nodes
// that may explain each frame. Not thread-safe.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/inference/lattice.h"

namespace motiondb::core {

class Model;

// alpha_t(j) = e_t(j) sum_i alpha_{t-1}(i) P(i -> j), made to sum to 1. The candidates j of a frame
// are found as DescendTree finds them (core/inference/node_path.h), except that it is the frame's
// own emission e that decides which stay in the beam: no other frame is looked at, so a frame costs
// O(layers * candidates * dimensions + candidates^2) once. With all nodes kept this is LastNodes of
// FindNodePaths over the whole stream. Where the rule leaves no way on, it starts anew.
class NodeFilter {
 public:
  // The model must outlive it. `layer` is one of its layers; 0 candidates keep all.
  NodeFilter(const Model& model, int layer, double transition_floor, int max_candidates = 16);

  // Takes the next frame: its scaled state (dimensions), NaN where a marker is missing. No
  // allocation once the vectors have grown.
  void Advance(const float* state);
  // The most probable node (of equals the first) if this were the next frame, which is not taken.
  NodeState Peek(const float* state);
  // The next frame is the first.
  void Restart() { now_.nodes.clear(); }

  int layer() const { return layer_; }
  // After the frames taken: nodes ascending, probabilities sum to 1.
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
  // Of a frame that sees nothing: where the graph leads from here.
  void Follow();
  // Sums over the candidates' arrivals from the nodes now.
  void Arrive();

  const Model& model_;
  const int layer_;
  const double floor_;
  const int max_candidates_;
  Distribution now_;
  Distribution next_;
  Candidates candidates_;
  Candidates above_;
  std::vector<double> densities_;
  std::vector<std::pair<double, std::int32_t>> leads_;
  std::vector<double> arriving_;  // sums over the ways to each candidate
};

}  // namespace motiondb::core
