// What a picture shows of the nodes of a layer (Figs. 9 and 10).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/view/state_axes.h"

namespace motiondb::core {

class Model;

struct NodeSummary {
  int frame_count = 0;
  // Index into Model::clips() of the clip with most frames in the node; ties: the first.
  int main_clip = 0;
  // Fraction (0 to 1) of the node's frames whose clips have the label of that clip.
  float label_fraction = 0;
  // In the first three principal axes, scaled units.
  Eigen::RowVector3f mean = Eigen::RowVector3f::Zero();
  // Rows: semi-axes of the ellipsoid of one standard deviation of the frames, longest first. The
  // component of each with the largest magnitude is positive.
  Eigen::Matrix<float, 3, 3, Eigen::RowMajor> semi_axes =
      Eigen::Matrix<float, 3, 3, Eigen::RowMajor>::Zero();
};

// Summarizes nodes from their frames. Used by one thread at a time.
class NodeSummaries {
 public:
  // `axes`: those of the model's states. Both must outlive this object. O(clips log clips).
  NodeSummaries(const Model& model, const StateAxes& axes);

  // O(frames of the node * log clips). REQUIRES: the node exists.
  NodeSummary Summarize(int layer, int node);

 private:
  const Model& model_;
  const StateAxes& axes_;
  std::vector<int> label_of_clip_;            // labels as numbers
  std::vector<std::int32_t> frames_of_clip_;  // scratch, zero between calls
};

// The mean of a node's states as a pose in the reference frame: x ahead, y to the left, z up.
struct MeanPose {
  Eigen::RowVectorXf positions_m;     // 1 x 3 N_v
  Eigen::RowVectorXf velocities_m_s;  // 1 x 3 N_v
};

// Returns the mean pose of a node, for the mean leg length of the model's clips. O(dimensions +
// clips). REQUIRES: the node exists.
MeanPose MeanPoseOf(const Model& model, int layer, int node);

}  // namespace motiondb::core
