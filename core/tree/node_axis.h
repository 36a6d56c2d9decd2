// The principal axis of a node's frames, at a cost of a few readings of them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/motion/matrix.h"
#include "core/tree/parallel.h"
#include "core/tree/principal_axis.h"

namespace motiondb::core {

// A node's states, one after the other. Not owned.
struct NodeRows {
  const float* data = nullptr;
  int count = 0;  // at least 1
  int dimensions = 0;

  const float* row(int r) const { return data + static_cast<std::ptrdiff_t>(r) * dimensions; }
};

// Nodes of at most this many frames get their axis to kTightTolerance, larger ones to
// kLooseTolerance.
inline constexpr int kTightFrames = 16384;
inline constexpr double kTightTolerance = 1e-6;
inline constexpr double kLooseTolerance = 1e-3;

struct NodeAxis {
  Eigen::VectorXd mean;
  PrincipalAxis principal;  // of the scatter matrix, the sum of c c^T over the centred states c
};

// Mean and principal axis. The axis's residual |S a - v a| / v is at most kTightTolerance or
// kLooseTolerance, beside rounding (about 1e-7 times the sum of |x|^2, over v): so v, the scatter
// along the axis, is within that part of an eigenvalue of S, and the sine of the angle to the true
// axis at most residual * v / (v - v2), v2 being the scatter along the second axis. Nodes of some
// thousand frames start from the dimension that varies most; larger ones from the axis of some
// thousand of their frames, evenly spread, which is also what tells apart axes of nearly the same
// scatter. `centred` is scratch, and keeps its memory for the next call. The same rows give the
// same axis, bit for bit, with any `parallel`. O(frames * dimensions) a product with S.
NodeAxis FindNodeAxis(const NodeRows& rows, std::vector<float>& centred,
                      const ParallelFor& parallel);

}  // namespace motiondb::core
