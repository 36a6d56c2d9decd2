#include "core/planning/splice.h"

#include "core/planning/ease.h"

namespace motiondb::core {
namespace {

// Weight of the run that begins, `offset` frames after the join.
double EnteringShare(const Join& join, double offset) {
  return join.half_window == 0 ? (offset > 0 ? 1.0 : 0.0)
                               : Ease(0.5 + 0.5 * offset / join.half_window);
}

// The step from `offset` to `offset` + 1 frames after the join.
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

}  // namespace motiondb::core
