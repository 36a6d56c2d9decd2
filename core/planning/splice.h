// Stored frames on the floor, one run after the other.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "core/model/model.h"
#include "core/planning/floor.h"

namespace motiondb::core {

// How stored frames move over the floor, in the size of the body that plays them. Immutable; the
// model must outlive it. Safe to share between threads.
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

// Playing runs of stored frames one after the other as one motion: at each join the run that ends
// fades into the one that begins. Safe to call from any thread.

// One run is left after frame `leave`, and the next goes on after frame `enter`, which is most like
// it. From `half_window` frames before to as many after, both are played at once, the first fading
// into the second; both clips have these frames.
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

// What is played at one frame: mostly a stored frame, within a join two.
struct PlayedFrame {
  int main = 0;      // the one that weighs more
  int fading = -1;   // the other; -1 outside joins
  double share = 0;  // of the fading one, below or at 0.5
};

std::vector<PlayedFrame> PlayedFrames(const SplicedPath& path);

// How the root moves from frame leave - half_window to enter + half_window: steps of both runs,
// one fading into the other.
FloorPose AcrossJoin(const StoredFloor& floor, const Join& join);

// Reference frames at each played frame, the first at the origin.
std::vector<FloorPose> PlayedRoot(const StoredFloor& floor, const SplicedPath& path);

// Smooth curves over the frames of a motion. Safe to call from any thread.

// A time as a number of frames, at least one.
Eigen::Index FramesOf(double seconds, double frame_rate_hz);

// Each row's mean with `reach` rows to either side of it, near ones weighing most (a raised
// cosine); the first and the last row stand for those beyond the ends. O(rows * reach).
Eigen::ArrayXXd Smooth(const Eigen::ArrayXXd& rows, Eigen::Index reach);

// A smooth curve that is nowhere below the values: the highest of `reach` to either side, smoothed
// over as many.
Eigen::ArrayXd Cover(const Eigen::ArrayXd& values, Eigen::Index reach);

// From 0 at share 0 to 1 at share 1 and no further, with no speed and no acceleration at either
// end, so that a blend adds no jolt.
inline double Ease(double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  return s * s * s * (s * (6 * s - 15) + 10);
}

}  // namespace motiondb::core
