#include "core/tree/divide_node.h"

namespace motiondb::core {
namespace {

// A node with this many times min_frames has many frames, of which this part may be set aside.
constexpr int kMany = 32;
constexpr int kMaxRounds = 32;
// Many frames alone do not tell a node that spoils a tree. In databases 1 and 2, HDM05 and the
// prediction clips, with the default settings at 25 to 120 Hz, leaves by the paper's rule have up
// to 113 * min_frames frames, for much the same reason; but none of them has more than 0.15 of its
// tree's frames. Of trees that one bad clip spoils, such a leaf has 0.55 of the frames, or all.
constexpr int kLargePart = 4;

bool IsLarge(std::int32_t frames, const DivisionRule& rule) {
  return frames / kMany >= rule.min_frames && frames > rule.all_frames / kLargePart;
}

}  // namespace

int DivideNode(const DivisionRule& rule, PermutedStates& permuted, NodePlaces& places,
               std::vector<float>& scratch, const ParallelFor& parallel, SplitPlane& plane) {
  const auto divide = [&](const NodePlaces& of) {
    return permuted.Divide(of.begin, of.end, rule.min_frames, scratch, parallel, plane);
  };
  int left = divide(places);
  const std::int32_t frames = places.end - places.begin;
  if (left > 0 || !IsLarge(frames, rule)) return left;

  NodePlaces others = places;
  for (int round = 0; left == 0 && round < kMaxRounds; ++round) {
    if (!permuted.SetAside(others.begin, others.end, parallel)) return 0;
    if (frames - (others.end - others.begin) > frames / kMany) return 0;
    left = divide(others);
  }
  if (left > 0) places = others;
  return left;
}

bool IsUndivided(const Tree& tree, int min_frames) {
  return tree.layer_count() == 1 && tree.frame_count() / kMany >= min_frames;
}

}  // namespace motiondb::core
