#include "tests/eval/peers/filling.h"

#include <cmath>

namespace motiondb::tests {

core::FrameMatrix FillByInterpolation(const core::StateSequence& observation) {
  core::FrameMatrix positions = core::WorldPositions(observation);
  const Eigen::Index frames = positions.rows();
  for (Eigen::Index m = 0; m < positions.cols() / 3; ++m) {
    auto marker = positions.middleCols<3>(3 * m);
    Eigen::Index last_seen = -1;  // the last frame with the marker
    for (Eigen::Index t = 0; t <= frames; ++t) {
      if (t < frames && std::isnan(marker(t, 0))) continue;
      for (Eigen::Index gap = last_seen + 1; gap < t; ++gap) {
        if (last_seen >= 0 && t < frames) {
          const float share =
              static_cast<float>(gap - last_seen) / static_cast<float>(t - last_seen);
          marker.row(gap) = (1 - share) * marker.row(last_seen) + share * marker.row(t);
        } else if (last_seen >= 0 || t < frames) {
          marker.row(gap) = marker.row(last_seen >= 0 ? last_seen : t);
        }
      }
      last_seen = t;
    }
  }
  return positions;
}

FillFromNearest::FillFromNearest(const ClipSet& training) : scale_(core::Scaling::kKind, training) {
  core::StateSequence all{.states = {}};
  Eigen::Index frames = 0;
  for (const EvalClip* clip : training) frames += clip->states.states.rows();
  all.states.resize(frames, training.front()->states.states.cols());
  Eigen::Index at = 0;
  for (const EvalClip* clip : training) {
    all.states.middleRows(at, clip->states.states.rows()) = clip->states.states;
    at += clip->states.states.rows();
  }
  stored_ = StoredFrames(scale_.Apply(all));
  states_ = std::move(all.states);
}

core::FrameMatrix FillFromNearest::Fill(const core::StateSequence& observation) const {
  const FrameDistances distances = DistancesTo(stored_, scale_.Apply(observation));
  core::StateSequence filled = observation;
  for (Eigen::Index t = 0; t < filled.states.rows(); ++t) {
    Eigen::Index nearest = 0;
    distances.squares.row(t).minCoeff(&nearest);
    auto row = filled.states.row(t);
    row = row.array().isNaN().select(states_.row(nearest), row);
  }
  return core::WorldPositions(filled);
}

}  // namespace motiondb::tests
