// Geometry for pictures of the states of a model (Figs. 6 to 10): principal axes of all states with
// the frames in them, and what is shown of the nodes of a layer.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "core/motion/matrix.h"

namespace motiondb::core {

class Model;

inline constexpr int kReportedAxes = 6;
inline constexpr int kDrawnAxes = 3;

// Immutable. Shared by threads.
struct StateAxes {
  Eigen::VectorXd mean;  // dimensions: the origin of the axes
  // dimensions x at most kReportedAxes: unit axes, by falling variance. The component of each axis
  // with the largest magnitude (ties: the first) is positive.
  Eigen::MatrixXd axes;
  // Fraction (0 to 1) of the total variance along each axis; 0 if all states are equal.
  Eigen::VectorXd variance_fractions;
  // frames x kDrawnAxes: the scaled states in the first axes. 0 for axes that do not exist.
  FrameMatrix projections;
};

// Returns the principal axes of the scaled states (frames x dimensions): eigenvectors of their
// covariance, which is summed in single precision over blocks of frames and in double over blocks.
// The result is bitwise identical for any `parallel`. O(frames * dimensions^2 + dimensions^3);
// memory: 12 bytes for each frame, and 40 for each pair of dimensions. CANCELLED; all threads call
// `cancelled`.
absl::StatusOr<StateAxes> FindStateAxes(const Eigen::Ref<const FrameMatrix>& states,
                                        const ParallelFor& parallel = RunSerially,
                                        const Cancelled& cancelled = {});

// Makes the component of the vector with the largest magnitude (ties: the first) positive.
template <typename Vector>
void FixSign(Vector&& vector) {
  Eigen::Index largest = 0;
  vector.cwiseAbs().maxCoeff(&largest);
  if (vector[largest] < 0) vector = -vector;
}

// What a picture shows of a node (Figs. 9 and 10).
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
