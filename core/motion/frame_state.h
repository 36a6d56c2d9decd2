// What a single frame needs for its state (section III-A): read from a whole motion or from one
// that is still coming in. Pure; safe to call from any thread.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace motiondb::core {

// Where the hips (m, world; NaN where missing) put the reference frame.
struct HipLine {
  bool placed = false;  // both hips are there
  bool turned = false;  // and the line between them lies flat enough to tell the front
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double heading = 0;  // of the front, rad, in (-1.5 pi, 0.5 pi]
};

inline HipLine ReadHips(const Eigen::Vector3d& left, const Eigen::Vector3d& right) {
  // Below this part of its length on the floor, the line between the hips no longer tells the
  // front.
  constexpr double kMinFloorShare = 0.2;
  HipLine hips;
  const Eigen::Vector3d across = left - right;
  hips.placed = across.allFinite();
  if (!hips.placed) return hips;
  hips.middle = (0.5 * (left + right)).head<2>();
  const double on_floor = across.head<2>().norm();
  hips.turned = on_floor > 0 && on_floor >= kMinFloorShare * across.norm();
  // Left is the frame's y axis; its x axis, the front, is a quarter turn to the right of it.
  if (hips.turned) hips.heading = std::atan2(across.y(), across.x()) - std::numbers::pi / 2;
  return hips;
}

// Writes the state (6 N_v) of a frame at `root` (x, y, heading). `marker_at(offset, m)` is marker m
// (Vector3d, m, world) of the frame itself (0), the one before (-1) or after (1); NaN where it is
// missing or there is no such frame. Velocities are central differences, one-sided where a
// neighbour is missing.
template <typename MarkerAt, typename State>
void MakeFrameState(const MarkerAt& marker_at, const Eigen::Vector3d& root, double frame_rate_hz,
                    double leg_length_m, State&& state) {
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(-root[2]).toRotationMatrix();
  const auto put = [&](Eigen::Index column, Eigen::Vector3d v) {
    v.head<2>() = turn * v.head<2>();
    state.template segment<3>(column) = (v / leg_length_m).template cast<float>().transpose();
  };
  for (Eigen::Index m = 0; m < state.size() / 6; ++m) {
    const Eigen::Vector3d here = marker_at(0, m);
    put(6 * m, here - Eigen::Vector3d(root[0], root[1], 0));
    // The neighbours that are there; the frame itself stands in for one that is not.
    double span = 0;
    const auto neighbour = [&](int offset) -> Eigen::Vector3d {
      const Eigen::Vector3d there = marker_at(offset, m);
      if (there.hasNaN()) return here;
      span += 1;
      return there;
    };
    const Eigen::Vector3d before = neighbour(-1);
    const Eigen::Vector3d after = neighbour(1);
    put(6 * m + 3, span > 0 ? Eigen::Vector3d((after - before) * frame_rate_hz / span)
                            : Eigen::Vector3d::Constant(std::nan("")));
  }
}

// Between the frames of a motion. Pure; safe to call from any thread.

// Between b and c, a share `u` of the way: Catmull-Rom, linear where an outer point is missing.
inline float CatmullRom(float a, float b, float c, float d, float u) {
  const float cubic =
      b + 0.5F * u * (c - a + u * (2 * a - 5 * b + 4 * c - d + u * (3 * (b - c) + d - a)));
  return std::isnan(cubic) ? b + u * (c - b) : cubic;
}

}  // namespace motiondb::core
