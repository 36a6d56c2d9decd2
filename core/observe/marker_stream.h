// Frames of a source's markers turned, one after the other, into frames of a marker set at a
// model's rate. Not thread-safe.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/marker_rules.h"
#include "core/motion/marker_set.h"
#include "core/motion/matrix.h"

namespace motiondb::core {

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
