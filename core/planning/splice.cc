#include "core/planning/splice.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace motiondb::core {

StoredFloor::StoredFloor(const Model& model, double leg_length_m, const ClipMask* mask)
    : model_(model),
      leg_length_m_(leg_length_m),
      axes_(static_cast<std::size_t>(model.frame_count())),
      lengths_(axes_.size()) {
  const double rate = model.settings().frame_rate_hz;
  const int span = std::max(1, static_cast<int>(std::lround(rate / 4)));
  double length = 0;
  for (std::size_t c = 0; c < model.clips().size(); ++c) {
    const ModelClip& clip = model.clips()[c];
    const bool is_playable = Allows(mask, static_cast<int>(c));
    const double scale = leg_length_m / clip.leg_length_m;
    for (int f = clip.first_frame; f < clip.first_frame + clip.frame_count; ++f) {
      const double heading = model.root_path()(f, 2);
      axes_[f] = {scale * std::cos(heading), scale * std::sin(heading)};
      if (f > clip.first_frame) {
        const FloorPose step = Between(f - 1, f);
        length += std::hypot(step.x, step.y);
      }
      lengths_[f] = length;
      if (is_playable && f >= clip.first_frame + span) {
        const FloorPose moved = Between(f - span, f);
        top_speed_m_s_ = std::max(top_speed_m_s_, std::hypot(moved.x, moved.y) * rate / span);
        top_turn_rad_s_ = std::max(top_turn_rad_s_, std::abs(moved.heading) * rate / span);
      }
    }
  }
}

namespace {

// Weight of the entering run, `offset` frames after the join.
double EnteringShare(const Join& join, double offset) {
  return join.half_window == 0 ? (offset > 0 ? 1.0 : 0.0)
                               : Ease(0.5 + 0.5 * offset / join.half_window);
}

// Returns the step from `offset` to `offset` + 1 frames after the join.
FloorPose BlendedStep(const StoredFloor& floor, const Join& join, int offset) {
  const FloorPose a = floor.Between(join.leave + offset, join.leave + offset + 1);
  const FloorPose b = floor.Between(join.enter + offset, join.enter + offset + 1);
  const double share = EnteringShare(join, offset + 0.5);
  return {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y),
          a.heading + share * (b.heading - a.heading)};
}

}  // namespace

std::vector<PlayedFrame> PlayedFrames(const SplicedPath& path) {
  std::vector<PlayedFrame> played;
  int next = path.start;
  for (const Join& join : path.joins) {
    for (; next <= join.leave; ++next) played.push_back({.main = next});
    next = join.enter + 1;
  }
  for (; next <= path.end; ++next) played.push_back({.main = next});

  int at = path.start;
  int index = 0;  // of frame `at`
  for (const Join& join : path.joins) {
    const int middle = index + join.leave - at;
    for (int offset = -join.half_window; offset <= join.half_window; ++offset) {
      const int k = middle + offset;
      if (k < 0 || k >= static_cast<int>(played.size())) continue;
      const double entering = EnteringShare(join, offset);
      played[k] = offset <= 0 ? PlayedFrame{join.leave + offset, join.enter + offset, entering}
                              : PlayedFrame{join.enter + offset, join.leave + offset, 1 - entering};
    }
    index = middle + 1;
    at = join.enter + 1;
  }
  return played;
}

FloorPose AcrossJoin(const StoredFloor& floor, const Join& join) {
  FloorPose pose;
  for (int offset = -join.half_window; offset < join.half_window; ++offset) {
    pose = pose * BlendedStep(floor, join, offset);
  }
  return pose;
}

std::vector<FloorPose> PlayedRoot(const StoredFloor& floor, const SplicedPath& path) {
  std::vector<FloorPose> root{{}};
  int at = path.start;
  const auto play_to = [&](int frame) {
    for (; at < frame; ++at) root.push_back(root.back() * floor.Between(at, at + 1));
  };
  for (const Join& join : path.joins) {
    play_to(join.leave - join.half_window);
    for (int offset = -join.half_window; offset < join.half_window; ++offset) {
      root.push_back(root.back() * BlendedStep(floor, join, offset));
    }
    at = join.enter + join.half_window;
  }
  play_to(path.end);
  return root;
}

Eigen::Index FramesOf(double seconds, double frame_rate_hz) {
  return std::max<Eigen::Index>(1, std::lround(seconds * frame_rate_hz));
}

Eigen::ArrayXXd Smooth(const Eigen::ArrayXXd& rows, Eigen::Index reach) {
  Eigen::ArrayXd weights(2 * reach + 1);
  for (Eigen::Index d = -reach; d <= reach; ++d) {
    const double angle = std::numbers::pi * static_cast<double>(d) / static_cast<double>(reach + 1);
    weights[d + reach] = 1 + std::cos(angle);
  }
  weights /= weights.sum();
  Eigen::ArrayXXd smooth = Eigen::ArrayXXd::Zero(rows.rows(), rows.cols());
  for (Eigen::Index t = 0; t < rows.rows(); ++t) {
    for (Eigen::Index d = -reach; d <= reach; ++d) {
      const Eigen::Index from = std::clamp<Eigen::Index>(t + d, 0, rows.rows() - 1);
      smooth.row(t) += weights[d + reach] * rows.row(from);
    }
  }
  return smooth;
}

Eigen::ArrayXd UpperEnvelope(const Eigen::ArrayXd& values, Eigen::Index reach) {
  Eigen::ArrayXd highest(values.size());
  for (Eigen::Index t = 0; t < values.size(); ++t) {
    const Eigen::Index first = std::max<Eigen::Index>(0, t - reach);
    const Eigen::Index last = std::min(values.size() - 1, t + reach);
    highest[t] = values.segment(first, last - first + 1).maxCoeff();
  }
  return Smooth(highest, reach);
}

}  // namespace motiondb::core
