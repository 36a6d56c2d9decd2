// States of the last frames of a stream: computed when a frame arrives, finished when the next one
// does. Not thread-safe.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/marker_set.h"
#include "core/motion/matrix.h"
#include "core/motion/states.h"

namespace motiondb::core {

// ComputeStates (core/motion/states.h) for streams. The newest frame has backward differences until
// its successor arrives, as in PastAt. A frame without hips keeps the reference frame of the
// previous one. The first frame is the first one with a valid hip line; earlier frames are ignored.
class ObservedStates {
 public:
  // Keeps the last `capacity` frames, at least three. `set` has hip landmarks.
  ObservedStates(MarkerSet set, double frame_rate_hz, int capacity);

  // Adds the next frame (3 N_v, m, world). Returns false if it is ignored. Does not allocate.
  bool Push(const Eigen::Ref<const Eigen::RowVectorXf>& positions_m);
  // Forgets all frames.
  void Restart() { next_ = 0; }

  // Leg length (m) for the next frames; 1 initially.
  void set_leg_length_m(double leg_length_m) { leg_length_m_ = leg_length_m; }
  double leg_length_m() const { return leg_length_m_; }

  // Number of the next frame, counted from 0.
  std::int64_t next() const { return next_; }
  // Number of kept frames: [next() - kept(), next()).
  int kept() const;
  // State of a frame: 6 N_v, leg lengths. Frame next() - 1 is provisional, the others are final.
  auto state(std::int64_t frame) const { return states_.row(frame % states_.rows()); }

  // Return the last `frames` frames, at most kept().
  StateSequence Last(int frames) const;
  MarkerMotion LastPositions(int frames) const;

 private:
  // Sets the frame's reference frame. Returns false if the first frame has none.
  bool Place(std::int64_t frame);
  void MakeState(std::int64_t frame);
  auto Marker(std::int64_t frame, Eigen::Index marker) const {
    return positions_.row(frame % positions_.rows()).segment<3>(3 * marker);
  }

  MarkerSet set_;
  double frame_rate_hz_;
  double leg_length_m_ = 1;
  std::int64_t next_ = 0;
  FrameMatrix positions_;  // rings: index is the frame number % rows
  RootPath root_path_;
  FrameMatrix states_;
};

// Converts a stream of source frames to the marker set and frame rate of a model: Represent
// (core/motion/states.h: ApplyScheme, Resample) for streams. Not thread-safe. If the rates differ,
// an interpolated frame needs two source frames after it, so the output lags by up to two source
// frames and is never revised.
class MarkerStream {
 public:
  // INVALID_ARGUMENT if no mapping of the scheme fits the names, the mapping needs link frames, or
  // the ratio of the rates exceeds 100.
  static absl::StatusOr<MarkerStream> Create(const MarkerScheme& scheme,
                                             const std::vector<std::string>& marker_names,
                                             double from_hz, double to_hz);

  Eigen::Index source_width() const { return missing_.size(); }

  // Adds the next frame (3 x source markers, m, NaN triples: missing). Read results with Next.
  void Push(const Eigen::Ref<const Eigen::RowVectorXf>& positions_m);
  // Adds a frame without markers.
  void PushMissing() { Push(missing_); }
  // Returns the next frame at the model's rate (3 N_v); null if none is ready.
  const Eigen::RowVectorXf* Next();
  // Starts another motion.
  void Restart();

 private:
  MarkerStream() = default;
  const Eigen::RowVectorXf& Row(std::int64_t frame) const;

  static constexpr std::int64_t kRows = 4;  // source frames of one interpolated frame

  BoundMapping mapping_;
  double step_ = 1;                       // source frames for each output frame
  Eigen::RowVectorXf missing_;            // a source frame without any marker
  std::vector<Eigen::RowVectorXf> rows_;  // mapped; source frame f is at f % kRows
  Eigen::RowVectorXf made_;
  std::int64_t taken_ = 0;  // number of source frames
  std::int64_t given_ = 0;  // number of output frames
};

}  // namespace motiondb::core
