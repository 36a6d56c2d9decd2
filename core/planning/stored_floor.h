// How stored frames move over the floor, in the size of the body that plays them. Immutable; the
// model must outlive it. Safe to share between threads.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/planning/floor_pose.h"

namespace motiondb::core {

class Model;

class StoredFloor {
 public:
  // Root paths are scaled from each clip's leg length to `leg_length_m`. O(frames).
  StoredFloor(const Model& model, double leg_length_m);

  double leg_length_m() const { return leg_length_m_; }
  // The reference frame of frame `to` as seen from that of frame `from`, both of one clip.
  FloorPose Between(int from, int to) const {
    const FloorPose& a = poses_[from];
    const FloorPose& b = poses_[to];
    const double c = facings_[from].x();
    const double s = facings_[from].y();
    return {c * (b.x - a.x) + s * (b.y - a.y), c * (b.y - a.y) - s * (b.x - a.x),
            b.heading - a.heading};
  }
  // Length (m) of the root's path between two frames of one clip, from <= to.
  double Length(int from, int to) const { return lengths_[to] - lengths_[from]; }

  // The fastest that frames go on average over a quarter of a second: bounds what any plan can do.
  double top_speed_m_s() const { return top_speed_m_s_; }
  double top_turn_rad_s() const { return top_turn_rad_s_; }

 private:
  double leg_length_m_ = 0;
  std::vector<FloorPose> poses_;          // in the clip's world
  std::vector<Eigen::Vector2d> facings_;  // cosine and sine of their headings
  std::vector<double> lengths_;           // from the model's first frame on
  double top_speed_m_s_ = 0;
  double top_turn_rad_s_ = 0;
};

}  // namespace motiondb::core
