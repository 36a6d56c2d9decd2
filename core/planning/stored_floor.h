// How stored frames move over the floor, in the size of the body that plays them. Immutable; the
// model must outlive it. Safe to share between threads.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/model/model.h"
#include "core/planning/floor_pose.h"

namespace motiondb::core {

class StoredFloor {
 public:
  // Root paths are scaled from each clip's leg length to `leg_length_m`. O(frames).
  StoredFloor(const Model& model, double leg_length_m);

  double leg_length_m() const { return leg_length_m_; }
  // The reference frame of frame `to` as seen from that of frame `from`, both of one clip.
  FloorPose Between(int from, int to) const {
    const RootPath& path = model_.root_path();
    const double dx = path(to, 0) - path(from, 0);
    const double dy = path(to, 1) - path(from, 1);
    const double c = axes_[from].x();
    const double s = axes_[from].y();
    return {c * dx + s * dy, c * dy - s * dx, path(to, 2) - path(from, 2)};
  }
  // Length (m) of the root's path between two frames of one clip, from <= to.
  double Length(int from, int to) const { return lengths_[to] - lengths_[from]; }

  // The fastest that frames go on average over a quarter of a second: bounds what any plan can do.
  double top_speed_m_s() const { return top_speed_m_s_; }
  double top_turn_rad_s() const { return top_turn_rad_s_; }

 private:
  const Model& model_;
  double leg_length_m_ = 0;
  std::vector<Eigen::Vector2d> axes_;  // cosine and sine of each heading times the clip's scale
  std::vector<double> lengths_;        // from the model's first frame on
  double top_speed_m_s_ = 0;
  double top_turn_rad_s_ = 0;
};

}  // namespace motiondb::core
