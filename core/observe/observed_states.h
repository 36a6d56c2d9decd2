// The last frames of a stream as states: each is made when it comes and finished when the next one
// does. Not thread-safe.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "core/motion/matrix.h"
#include "core/motion/states.h"

namespace motiondb::core {

// What ComputeStates does (core/motion/states.h), knowing nothing of what comes: the newest frame's
// velocities are backward differences until its successor comes, as PastAt gives them, and a frame
// without hips keeps the reference frame of the one before. The first frame is the first with both
// hips apart on the floor; what comes before it is passed over.
class ObservedStates {
 public:
  // Keeps the last `capacity` frames, three at least. `set` names its hips.
  ObservedStates(MarkerSet set, double frame_rate_hz, int capacity);

  // Takes the next frame (3 N_v, m, world). False where it is passed over. No allocation.
  bool Push(const Eigen::Ref<const Eigen::RowVectorXf>& positions_m);
  // Forgets all frames.
  void Restart() { next_ = 0; }

  // What lengths are divided by, from the next frame on; 1 at first.
  void set_leg_length_m(double leg_length_m) { leg_length_m_ = leg_length_m; }
  double leg_length_m() const { return leg_length_m_; }

  // Frames are numbered from 0, the first one; this is the next one's number.
  std::int64_t next() const { return next_; }
  // How many are kept: [next() - kept(), next()).
  int kept() const;
  // 6 N_v, leg lengths; frame next() - 1 is provisional, the others are finished.
  auto state(std::int64_t frame) const { return states_.row(frame % states_.rows()); }

  // The last frames, at most kept().
  StateSequence Last(int frames) const;
  MarkerMotion LastPositions(int frames) const;

 private:
  // False if the frame, which would be the first, has no reference frame.
  bool Place(std::int64_t frame);
  void MakeState(std::int64_t frame);
  auto Marker(std::int64_t frame, Eigen::Index marker) const {
    return positions_.row(frame % positions_.rows()).segment<3>(3 * marker);
  }

  MarkerSet set_;
  double frame_rate_hz_;
  double leg_length_m_ = 1;
  std::int64_t next_ = 0;
  FrameMatrix positions_;  // rings: a frame is at its number % rows
  RootPath root_path_;
  FrameMatrix states_;
};

}  // namespace motiondb::core
