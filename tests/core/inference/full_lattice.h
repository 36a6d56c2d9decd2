// The lattice of exact Viterbi: all nodes are candidates.
#pragma once

#include "core/inference/lattice.h"
#include "core/model/model.h"

namespace motiondb::tests {

// Returns every node of a layer for every frame, with eq. 8 over all of them.
inline core::Lattice FullLattice(const core::Model& model, int layer,
                                 const core::FrameMatrix& scaled) {
  core::Lattice lattice;
  for (Eigen::Index t = 0; t < scaled.rows(); ++t) {
    core::LatticeFrame& frame = lattice.emplace_back();
    const int nodes = model.tree().node_count(layer);
    frame.log_emission.resize(nodes);
    for (int node = 0; node < nodes; ++node) {
      frame.nodes.push_back(node);
      frame.log_emission[node] =
          model.gaussians().LogDensity(model.tree().branch(layer, node), scaled.row(t).data());
    }
    core::NormalizeEmission(frame.log_emission);
  }
  return lattice;
}

}  // namespace motiondb::tests
