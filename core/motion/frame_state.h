// State vector of a single frame (section III-A), for complete motions and for streams.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace motiondb::core {

// Position and heading of the reference frame, from the hips (m, world; NaN if missing).
struct HipLine {
  bool placed = false;  // both hips are present
  bool turned = false;  // and the hip line is horizontal enough to define the front
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double heading = 0;  // of the front, rad, in (-1.5 pi, 0.5 pi]
};

inline HipLine ReadHips(const Eigen::Vector3d& left, const Eigen::Vector3d& right) {
  // Minimum ratio of the hip line's horizontal length to its length.
  constexpr double kMinHorizontalRatio = 0.2;
  HipLine hips;
  const Eigen::Vector3d across = left - right;
  hips.placed = across.allFinite();
  if (!hips.placed) return hips;
  hips.middle = (0.5 * (left + right)).head<2>();
  const double on_floor = across.head<2>().norm();
  hips.turned = on_floor > 0 && on_floor >= kMinHorizontalRatio * across.norm();
  // Left is the frame's y axis; the front is its x axis, 90 degrees to the right of y.
  if (hips.turned) hips.heading = std::atan2(across.y(), across.x()) - std::numbers::pi / 2;
  return hips;
}

// Writes the state (6 N_v) of a frame with the reference frame `root` (x, y, heading).
// `marker_at(offset, m)` returns marker m (Vector3d, m, world) of this frame (0), the previous (-1)
// or the next (1); NaN if the marker or the frame does not exist. Velocities are central
// differences, one-sided if a neighbour is missing.
template <typename MarkerAt, typename State>
void MakeFrameState(const MarkerAt& marker_at, const Eigen::Vector3d& root, double frame_rate_hz,
                    double leg_length_m, State&& state) {
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(-root[2]).toRotationMatrix();
  const auto put = [&](Eigen::Index column, Eigen::Vector3d v) {
    v.head<2>() = turn * v.head<2>();
    state.template segment<3>(column) = (v / leg_length_m).template cast<float>().transpose();
  };
  for (Eigen::Index m = 0; m < state.size() / 6; ++m) {
    const Eigen::Vector3d current = marker_at(0, m);
    put(6 * m, current - Eigen::Vector3d(root[0], root[1], 0));
    // A missing neighbour is replaced by this frame.
    double span = 0;
    const auto neighbour = [&](int offset) -> Eigen::Vector3d {
      const Eigen::Vector3d adjacent = marker_at(offset, m);
      if (adjacent.hasNaN()) return current;
      span += 1;
      return adjacent;
    };
    const Eigen::Vector3d before = neighbour(-1);
    const Eigen::Vector3d after = neighbour(1);
    put(6 * m + 3, span > 0 ? Eigen::Vector3d((after - before) * frame_rate_hz / span)
                            : Eigen::Vector3d::Constant(std::nan("")));
  }
}

// Interpolates between b (u = 0) and c (u = 1): Catmull-Rom, linear if an outer point is missing.
inline float CatmullRom(float a, float b, float c, float d, float u) {
  const float cubic =
      b + 0.5F * u * (c - a + u * (2 * a - 5 * b + 4 * c - d + u * (3 * (b - c) + d - a)));
  return std::isnan(cubic) ? b + u * (c - b) : cubic;
}

}  // namespace motiondb::core
