#include "core/inference/stored_futures.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace motiondb::core {
namespace {

double Distance(const Model& model, int frame, const float* state) {
  const auto row = model.states().row(frame);
  double squares = 0;
  int present = 0;
  for (Eigen::Index d = 0; d < row.size(); ++d) {
    if (std::isnan(state[d])) continue;
    const double difference = row[d] - state[d];
    squares += difference * difference;
    ++present;
  }
  return present == 0 ? 0 : squares / present;
}

// Marker positions of a stored frame in the reference frame of frame `from`, leg lengths.
Eigen::VectorXd PositionsSeenFrom(const Model& model, int from, int frame, double leg_length_m) {
  const auto& root = model.root_path();
  const double turn = root(frame, 2) - root(from, 2);
  const double c = std::cos(root(from, 2));
  const double s = std::sin(root(from, 2));
  const Eigen::Vector2d moved = (root.row(frame) - root.row(from)).head<2>() / leg_length_m;
  const Eigen::Vector2d origin(c * moved.x() + s * moved.y(), -s * moved.x() + c * moved.y());
  const double ct = std::cos(turn);
  const double st = std::sin(turn);
  Eigen::VectorXd positions(model.states().cols() / 2);
  for (Eigen::Index m = 0; m < positions.size() / 3; ++m) {
    const Eigen::Vector3d p = model.states()
                                  .row(frame)
                                  .segment<3>(6 * m)
                                  .cwiseProduct(model.scale().divisor.segment<3>(6 * m))
                                  .cast<double>()
                                  .transpose();
    positions.segment<3>(3 * m) << origin.x() + ct * p.x() - st * p.y(),
        origin.y() + st * p.x() + ct * p.y(), p.z();
  }
  return positions;
}

}  // namespace

std::vector<Exemplar> NearestFrames(const Model& model, const std::vector<int>& branches,
                                    const float* state, int count) {
  std::vector<std::pair<double, int>> nearest;
  for (int b : branches) {
    const Branch& branch = model.tree().branches()[b];
    for (std::int32_t i = branch.begin; i < branch.end; ++i) {
      const int frame = model.tree().frame_order()[i];
      nearest.emplace_back(Distance(model, frame, state), frame);
    }
  }
  const auto kept = std::min<std::size_t>(count, nearest.size());
  std::partial_sort(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(kept),
                    nearest.end());
  nearest.resize(kept);
  std::vector<Exemplar> exemplars;
  if (nearest.empty()) return exemplars;
  const double closest = nearest.front().first;
  const double spread = std::max(nearest[kept / 2].first - closest, 1e-12);
  double sum = 0;
  for (const auto& [distance, frame] : nearest) {
    exemplars.push_back({frame, std::exp(-0.5 * (distance - closest) / spread)});
    sum += exemplars.back().weight;
  }
  for (Exemplar& exemplar : exemplars) exemplar.weight /= sum;
  return exemplars;
}

Eigen::VectorXd FutureDisplacement(const Model& model, int frame, double ahead_frames) {
  const ModelClip& clip = model.clips()[model.clip_of_frame(frame)];
  const int before = frame + static_cast<int>(std::floor(ahead_frames));
  const double fraction = ahead_frames - std::floor(ahead_frames);
  const int after = fraction > 1e-9 ? before + 1 : before;
  if (after >= clip.first_frame + clip.frame_count) return {};
  Eigen::VectorXd future = PositionsSeenFrom(model, frame, before, clip.leg_length_m);
  if (after != before) {
    future = (1 - fraction) * future +
             fraction * PositionsSeenFrom(model, frame, after, clip.leg_length_m);
  }
  return future - PositionsSeenFrom(model, frame, frame, clip.leg_length_m);
}

}  // namespace motiondb::core
