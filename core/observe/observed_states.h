// The last frames of a stream as states: each is made when it comes and finished when the next one
// does. Not thread-safe.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/marker_rules.h"
#include "core/motion/marker_set.h"
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

// Frames of a source's markers turned, one after the other, into frames of a marker set at a
// model's rate. Not thread-safe.

// What Represent does with an observation (core/motion/states.h: ApplyScheme, Resample), frame by
// frame. At another rate than the model's a frame between two that came is made as soon as all that
// core's Resample looks at is there: cubic interpolation wants the second frame after it, so the
// stream lags by up to two of its own frames and nothing is ever taken back.
class MarkerStream {
 public:
  // INVALID_ARGUMENT if the scheme has no mapping for the names, a mapping wants link frames, which
  // bare markers lack, or the rates are more than a hundredfold apart.
  static absl::StatusOr<MarkerStream> Create(const MarkerScheme& scheme,
                                             const std::vector<std::string>& marker_names,
                                             double from_hz, double to_hz);

  Eigen::Index source_width() const { return missing_.size(); }

  // Takes the next frame (3 x source markers, m, NaN triples where missing). Frames made of it wait
  // for Next.
  void Push(const Eigen::Ref<const Eigen::RowVectorXf>& positions_m);
  // A frame in which all is missing.
  void PushMissing() { Push(missing_); }
  // The next frame at the model's rate (3 N_v); null where none is ready.
  const Eigen::RowVectorXf* Next();
  // The next frame is the first of another motion.
  void Restart();

 private:
  MarkerStream() = default;
  const Eigen::RowVectorXf& Row(std::int64_t frame) const;

  static constexpr std::int64_t kRows = 4;  // that a frame is made of

  BoundMapping mapping_;
  double step_ = 1;                       // source frames from one frame to the next
  Eigen::RowVectorXf missing_;            // a source frame without any marker
  std::vector<Eigen::RowVectorXf> rows_;  // mapped; source frame f is at f % kRows
  Eigen::RowVectorXf made_;
  std::int64_t taken_ = 0;  // source frames
  std::int64_t given_ = 0;  // frames at the model's rate
};

}  // namespace motiondb::core
