// What an observation lacks, as stored motion has it beside what was seen. Safe to call from any
// thread.
#pragma once

#include "core/model/motion_metric.h"

namespace motiondb::core {

// Replaces the NaN of a scaled state (D) by their mean given its other dimensions, under the
// metric's probabilistic PCA: with o what was seen and L the loadings, h = (L_o^T L_o + noise I)^-1
// L_o^T (x_o - mean_o) and x = mean + L h. O(q^2 D).
void FillUnseen(const MotionMetric& metric, Eigen::Ref<Eigen::RowVectorXf> state);

}  // namespace motiondb::core
