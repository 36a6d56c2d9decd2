// What followed, in the stored motion, on frames like the one observed: the source of predicted
// poses. Safe to call from any thread.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/model/model.h"

namespace motiondb::core {

// A stored frame taken as an example, and how much it counts.
struct Exemplar {
  int frame = 0;
  double weight = 0;  // weights of a set sum to 1
};

// The stored frames nearest to a scaled state (dimensions, NaN left out) among those under
// `branches`, at most `count`, weighted by closeness. The mean squared difference a dimension is
// the distance; the weight falls to exp(-1/2) at the distance of the median exemplar. O(frames
// under the branches).
std::vector<Exemplar> NearestFrames(const Model& model, const std::vector<int>& branches,
                                    const float* state, int count);

// How the markers moved from a stored frame to `ahead_frames` later (a fraction between frames is
// interpolated), both seen from the reference frame at the stored frame: 3 N_v numbers in leg
// lengths. Empty where the clip ends before that.
Eigen::VectorXd FutureDisplacement(const Model& model, int frame, double ahead_frames);

}  // namespace motiondb::core
