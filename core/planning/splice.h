// Stored frames on the floor, spliced from several runs.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "core/model/clip_mask.h"
#include "core/model/model.h"
#include "core/planning/floor.h"

namespace motiondb::core {

// Motion of stored frames over the floor, scaled to the body that plays them. Immutable; the model
// must outlive it.
class StoredFloor {
 public:
  // Scales root paths from each clip's leg length to `leg_length_m`. `mask`: the clips that may be
  // played; null: all. O(frames).
  StoredFloor(const Model& model, double leg_length_m, const ClipMask* mask = nullptr);

  double leg_length_m() const { return leg_length_m_; }
  // Returns the reference frame of frame `to` relative to that of frame `from`, in one clip.
  FloorPose Between(int from, int to) const {
    const RootPath& path = model_.root_path();
    const double dx = path(to, 0) - path(from, 0);
    const double dy = path(to, 1) - path(from, 1);
    const double c = axes_[from].x();
    const double s = axes_[from].y();
    return {c * dx + s * dy, c * dy - s * dx, path(to, 2) - path(from, 2)};
  }
  // Returns the length (m) of the root's path between two frames of one clip, from <= to.
  double Length(int from, int to) const { return lengths_[to] - lengths_[from]; }

  // Maximum average speeds over 0.25 s in the clips that may be played: bounds for any plan.
  double top_speed_m_s() const { return top_speed_m_s_; }
  double top_turn_rad_s() const { return top_turn_rad_s_; }

 private:
  const Model& model_;
  double leg_length_m_ = 0;
  std::vector<Eigen::Vector2d> axes_;  // cosine and sine of each heading times the clip's scale
  std::vector<double> lengths_;        // cumulative from the model's first frame
  double top_speed_m_s_ = 0;
  double top_turn_rad_s_ = 0;
};

// A join of two runs: the first ends after frame `leave`, the next continues after the similar
// frame `enter`. Within `half_window` frames on both sides, both are played, the first fading into
// the second; both clips have these frames.
struct Join {
  int leave = 0;
  int enter = 0;
  int half_window = 0;
};

// Frames start, start + 1 ... joins[0].leave, joins[0].enter + 1 ... end. Windows do not overlap.
struct SplicedPath {
  int start = 0;
  std::vector<Join> joins;
  int end = 0;
};

// One played frame: a stored frame, or two within a join.
struct PlayedFrame {
  int main = 0;      // the frame with the larger weight
  int fading = -1;   // the other frame; -1 outside joins
  double share = 0;  // weight of the fading frame, at most 0.5
};

std::vector<PlayedFrame> PlayedFrames(const SplicedPath& path);

// Returns the motion of the root from frame leave - half_window to enter + half_window: steps of
// both runs, blended.
FloorPose AcrossJoin(const StoredFloor& floor, const Join& join);

// Returns the reference frame of each played frame, the first at the origin.
std::vector<FloorPose> PlayedRoot(const StoredFloor& floor, const SplicedPath& path);

// Converts a time to a number of frames, at least one.
Eigen::Index FramesOf(double seconds, double frame_rate_hz);

// Returns each row's weighted mean with `reach` rows on both sides (raised cosine); rows beyond the
// ends repeat the first and the last row. O(rows * reach).
Eigen::ArrayXXd Smooth(const Eigen::ArrayXXd& rows, Eigen::Index reach);

// Returns a smooth upper envelope: the maximum over `reach` rows on both sides, smoothed over as
// many.
Eigen::ArrayXd UpperEnvelope(const Eigen::ArrayXd& values, Eigen::Index reach);

// Returns a smooth step from 0 at share 0 to 1 at share 1, clamped, with zero velocity and
// acceleration at both ends.
inline double Ease(double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  return s * s * s * (s * (6 * s - 15) + 10);
}

}  // namespace motiondb::core
