#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "core/mapping/figure.h"
#include "core/mapping/limbs.h"

namespace motiondb::core {
namespace {

// Lengths in leg lengths (hip to ankle), from the same source as those of the limbs: trunk 0.288,
// neck and head 0.182, legs 0.491 of the stature.
constexpr double kLegToArm = 1.48;
constexpr double kTrunk = 0.59;
constexpr double kHead = 0.37;

// The chain from the branching of the arms to the top of the head.
struct HeadChain {
  std::vector<int> joints;  // without the branching
  double score = 0;
};

double NameOf(const BoneTree& tree, int joint, Role role) {
  return tree.meaning(joint).fit_for(role);
}

// Follows the names of neck and head, or else the longest way.
std::vector<int> FollowHead(const BoneTree& tree, int root) {
  std::vector<int> chain = {root};
  while (!tree.children(chain.back()).empty()) {
    chain.push_back(*std::ranges::max_element(tree.children(chain.back()), {}, [&](int child) {
      const double named =
          std::max({NameOf(tree, child, Role::kNeck), NameOf(tree, child, Role::kHead),
                    NameOf(tree, child, Role::kHeadTop)});
      const double way = tree.meaning(child).is_accessory ? 0.1 : 1;
      return 100 * named + way * (tree.length(child) + tree.reach(child));
    }));
    if (tree.meaning(chain.back()).is_accessory) {
      chain.pop_back();
      break;
    }
  }
  return chain;
}

HeadChain FindHead(const BoneTree& tree, const LimbPair& arms, std::span<const int> spine,
                   double leg) {
  HeadChain best;
  for (const int child : tree.children(arms.branching)) {
    if (child == arms.roots[0] || child == arms.roots[1]) continue;
    if (std::ranges::find(spine, child) != spine.end()) continue;
    HeadChain head{.joints = FollowHead(tree, child)};
    double length = 0;
    double named = 0;
    for (const int joint : head.joints) {
      length += tree.length(joint);
      named = std::max({named, NameOf(tree, joint, Role::kHead), NameOf(tree, joint, Role::kNeck)});
    }
    // The head continues the trunk.
    double along = 0;
    for (const auto& frame : tree.points().frames) {
      const Eigen::Vector3d trunk = frame.col(arms.branching) - frame.col(spine.front());
      const Eigen::Vector3d up = frame.col(head.joints.back()) - frame.col(arms.branching);
      const double product = trunk.norm() * up.norm();
      if (product > 0) along += trunk.dot(up) / product;
    }
    along /= static_cast<double>(tree.points().frames.size());
    const double accessory = tree.meaning(child).is_accessory ? 0.2 : 1;
    head.score = accessory * (named + Bell(length / leg - kHead, 0.2) + 0.5 * along);
    if (head.score > best.score) best = head;
  }
  return best;
}

struct Candidate {
  LimbPair legs;
  LimbPair arms;
  std::vector<int> spine;  // from the branching of the legs to that of the arms
  HeadChain head;
  double score = 0;
};

std::optional<Candidate> Consider(const BoneTree& tree, const LimbPair& legs,
                                  const LimbPair& arms) {
  for (const int leg : legs.roots) {
    for (const int arm : arms.roots) {
      if (tree.IsAncestor(leg, arm) || tree.IsAncestor(arm, leg)) return std::nullopt;
    }
  }
  Candidate candidate{
      .legs = legs, .arms = arms, .spine = tree.Path(legs.branching, arms.branching)};
  const double leg = legs.as_legs[0].length();
  if (candidate.spine.empty() || !(leg > 0)) return std::nullopt;
  const double trunk = tree.PathLength(candidate.spine);
  candidate.head = FindHead(tree, arms, candidate.spine, leg);
  const double ratio = std::log(leg / arms.as_arms[0].length() / kLegToArm);
  candidate.score = legs.leg_score() + arms.arm_score() + 2 * Bell(ratio, 0.25) +
                    2 * Bell(trunk / leg - kTrunk, 0.2) + 1.5 * candidate.head.score;
  return candidate;
}

double Confidence(double name, double shape) { return 1 - (1 - 0.9 * name) * (1 - 0.7 * shape); }

void SetLimb(const BoneTree& tree, const Limb& limb, double symmetry, bool is_leg, Side side,
             Figure& figure) {
  const double shape = limb.shape_score * symmetry;
  const auto set = [&](Role role, int joint, double share = 1) {
    if (joint < 0) return;
    figure.at(role, side) = {joint, share * Confidence(NameOf(tree, joint, role), shape)};
  };
  if (is_leg) {
    set(Role::kHip, limb.upper);
    set(Role::kKnee, limb.middle);
    set(Role::kAnkle, limb.lower);
    set(Role::kToe, limb.end);
    if (limb.tip != limb.end) set(Role::kToeTip, limb.tip);
  } else {
    set(Role::kClavicle, limb.inner);
    set(Role::kShoulder, limb.upper);
    set(Role::kElbow, limb.middle);
    set(Role::kWrist, limb.lower);
    set(Role::kHand, limb.end);
  }
}

// A foot without a joint at the ball: its tip may be the ball or the end of the toes.
void FindToes(const BoneTree& tree, Side side, Figure& figure) {
  RolePoint& toe = figure.at(Role::kToe, side);
  RolePoint& tip = figure.at(Role::kToeTip, side);
  const RolePoint& ankle = figure.at(Role::kAnkle, side);
  // A heel is behind or below the ankle; it is a branch of its own.
  for (int j = ankle.index + 1; j < tree.count(); ++j) {
    if (NameOf(tree, j, Role::kHeel) > 0.5 && tree.IsAncestor(ankle.index, j)) {
      figure.at(Role::kHeel, side) = {j, ankle.confidence};
    }
  }
  if (toe.is_found() || !tip.is_found()) return;
  if (NameOf(tree, tip.index, Role::kToeTip) < NameOf(tree, tip.index, Role::kToe)) {
    toe = tip;
    tip = {};
  }
}

void SetMiddle(const BoneTree& tree, const Candidate& candidate, Figure& figure) {
  const std::vector<int>& spine = candidate.spine;
  const std::vector<int>& head = candidate.head.joints;
  const double head_shape = std::clamp(candidate.head.score / 2.5, 0.0, 1.0);
  const auto best_of = [&](std::span<const int> joints, Role role) {
    int best = -1;
    double fit = 0.4;
    for (const int joint : joints) {
      if (NameOf(tree, joint, role) <= fit) continue;
      fit = NameOf(tree, joint, role);
      best = joint;
    }
    return best;
  };
  const auto set = [&](Role role, int joint, double shape) {
    if (joint >= 0) figure.at(role) = {joint, Confidence(NameOf(tree, joint, role), shape)};
  };
  const int pelvis = best_of(spine, Role::kPelvis);
  set(Role::kPelvis, pelvis >= 0 ? pelvis : spine.front(), 1);
  // Names of the neck may be on either side of the branching of the arms.
  int neck = best_of(head, Role::kNeck);
  if (neck < 0) neck = best_of(std::span(spine).subspan(spine.size() / 2), Role::kNeck);
  int skull = best_of(head, Role::kHead);
  int top = best_of(head, Role::kHeadTop);
  if (skull < 0 && !head.empty()) {
    // neck, ..., head, top of the head; or neck and head; or head alone
    const bool has_top = top >= 0 || tree.children(head.back()).empty();
    const std::size_t from_end = has_top && head.size() >= 2 ? 2 : 1;
    skull = head[head.size() - from_end];
    if (top < 0 && from_end == 2) top = head.back();
  }
  if (top < 0 && !head.empty() && skull >= 0 && head.back() != skull) top = head.back();
  if (neck < 0 && head.size() >= 2 && head.front() != skull) neck = head.front();
  if (neck < 0) neck = spine.back();
  set(Role::kNeck, neck, head_shape);
  set(Role::kHead, skull, head_shape);
  set(Role::kHeadTop, top, head_shape);
  for (const int joint : spine) {
    if (joint != neck && joint != spine.front()) figure.spine.push_back(joint);
  }
  if (!figure.spine.empty()) set(Role::kSpine, figure.spine.back(), 1);
}

}  // namespace

std::optional<Figure> FindInHierarchy(const PointCloud& points,
                                      const std::vector<NameMeaning>& meanings) {
  const BoneTree tree(points, meanings);
  const std::vector<LimbPair> pairs = FindLimbPairs(tree);
  std::optional<Candidate> best;
  for (std::size_t l = 0; l < pairs.size(); ++l) {
    for (std::size_t a = 0; a < pairs.size(); ++a) {
      if (l == a || pairs[a].as_arms[0].upper < 0 || pairs[a].as_arms[1].upper < 0) continue;
      auto candidate = Consider(tree, pairs[l], pairs[a]);
      if (candidate && (!best || candidate->score > best->score)) best = std::move(candidate);
    }
  }
  if (!best) return std::nullopt;
  Figure figure;
  figure.names = points.names;
  for (const Side side : {Side::kLeft, Side::kRight}) {
    const int s = side == Side::kRight ? 1 : 0;
    SetLimb(tree, best->legs.as_legs[s], best->legs.symmetry, true, side, figure);
    SetLimb(tree, best->arms.as_arms[s], best->arms.symmetry, false, side, figure);
    FindToes(tree, side, figure);
  }
  SetMiddle(tree, *best, figure);
  return figure;
}

}  // namespace motiondb::core
