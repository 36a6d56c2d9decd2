#include "core/mapping/limbs.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

namespace motiondb::core {
namespace {

// Lengths of a person's limbs, as ratios, with their tolerances (standard deviation of the
// logarithm). Drillis and Contini's body segment lengths, as shares of the stature: thigh 0.245,
// shank 0.246, foot length 0.152; upper arm 0.186, forearm 0.146, hand 0.108.
struct LimbShape {
  Role upper;
  Role middle;
  Role lower;
  Role end;
  double upper_to_lower;
  double tolerance;
  double max_before;  // in limb lengths
  double max_after;
};
constexpr LimbShape kLeg = {Role::kHip, Role::kKnee, Role::kAnkle, Role::kToe,
                            1.0,        0.25,        0.35,         0.45};
constexpr LimbShape kArm = {
    Role::kShoulder, Role::kElbow, Role::kWrist, Role::kHand, 1.15, 0.35, 0.65, 0.75};

constexpr double kBendingShare = 0.15;     // of the shape's score
constexpr double kMinShareOfReach = 0.12;  // of the longest path of the hierarchy
constexpr double kMinSymmetry = 0.6;
constexpr std::size_t kMaxChain = 16;

// A chain of joints from the branching on, with what the choice of joints depends on.
class LimbChain {
 public:
  LimbChain(const BoneTree& tree, int root) : tree_(tree), joints_(tree.LongestPath(root)) {
    if (joints_.size() > kMaxChain) joints_.resize(kMaxChain);
    at_ = {tree.length(joints_[0])};
    for (std::size_t i = 1; i < size(); ++i) at_.push_back(at_.back() + tree.length(joints_[i]));
    for (std::size_t i = 0; i < size(); ++i) {
      for (std::size_t k = 0; k < size(); ++k) {
        bones_[i][k] = i < k ? tree.MeasureBone(joints_[i], joints_[k]) : Bone{};
      }
    }
  }

  std::size_t size() const { return joints_.size(); }
  const std::vector<int>& joints() const { return joints_; }

  // Returns the limb with these joints of the chain; its scores are 0 if it has no length.
  Limb Choose(const LimbShape& shape, std::size_t u, std::size_t m, std::size_t l) const {
    Limb limb;
    limb.upper = joints_[u];
    limb.middle = joints_[m];
    limb.lower = joints_[l];
    limb.tip = l + 1 < size() ? joints_.back() : -1;
    limb.upper_length = bones_[u][m].length;
    limb.lower_length = bones_[m][l].length;
    limb.before = at_[u];
    limb.after = at_.back() - at_[l];
    const double length = limb.length();
    if (!(limb.upper_length > 0 && limb.lower_length > 0)) return limb;
    limb.name_score = (Fit(u, shape.upper) + Fit(m, shape.middle) + Fit(l, shape.lower)) / 3.0;
    const double ratio = std::log(limb.upper_length / limb.lower_length / shape.upper_to_lower);
    const double before = std::max(0.0, limb.before / length - shape.max_before);
    const double after = std::max(0.0, limb.after / length - shape.max_after);
    // A limb ends in a foot or a hand.
    const double has_end = limb.after > 0.04 * length ? 1 : 0.7;
    // A bone is rigid: a joint that bends between its ends changes their distance.
    const double rigid = Bell(bones_[u][m].variation, 0.03) * Bell(bones_[m][l].variation, 0.03);
    limb.shape_score = (1 - kBendingShare) * Bell(ratio, shape.tolerance) * Bell(before, 0.2) *
                       Bell(after, 0.25) * has_end * rigid;
    return limb;
  }

  // Adds to the score what depends on the motion.
  void AddBending(Limb& limb) const {
    const double bends = tree_.BendingRange(limb.upper, limb.middle, limb.lower);
    limb.shape_score += kBendingShare * std::min(1.0, bends / 0.5);
  }

  // Finds the ball of the foot or the knuckles, and the clavicle.
  void FindEnds(const LimbShape& shape, Limb& limb) const {
    const auto upper =
        static_cast<std::size_t>(std::ranges::find(joints_, limb.upper) - joints_.begin());
    const auto lower =
        static_cast<std::size_t>(std::ranges::find(joints_, limb.lower) - joints_.begin());
    // By name, or else the first joint that is not in the place of the ankle or wrist.
    float named = 0.3F;
    for (std::size_t i = lower + 1; i < size(); ++i) {
      if (Fit(i, shape.end) <= named) continue;
      named = Fit(i, shape.end);
      limb.end = joints_[i];
    }
    for (std::size_t i = lower + 1; i + 1 < size() && limb.end < 0; ++i) {
      if (at_[i] - at_[lower] > 0.05 * limb.length()) limb.end = joints_[i];
    }
    if (upper > 0) limb.inner = joints_[upper - 1];
    for (std::size_t i = 0; i < upper; ++i) {
      if (Fit(i, Role::kClavicle) > 0.5F) limb.inner = joints_[i];
    }
  }

 private:
  float Fit(std::size_t i, Role role) const { return tree_.meaning(joints_[i]).fit_for(role); }

  const BoneTree& tree_;
  std::vector<int> joints_;
  std::vector<double> at_;  // distance of each joint from the branching along the bones
  std::array<std::array<Bone, kMaxChain>, kMaxChain> bones_;
};

// Chooses the joints of two limbs: the same on both chains if they are equally long.
std::array<Limb, 2> FitLimbs(const LimbShape& shape, const LimbChain& a, const LimbChain& b) {
  std::array<Limb, 2> best;
  const bool is_same = a.size() == b.size();
  const auto fit = [&](const LimbChain& chain, const LimbChain* mirrored, Limb& first,
                       Limb* second) {
    double best_score = -1;
    for (std::size_t u = 0; u + 2 < chain.size(); ++u) {
      for (std::size_t m = u + 1; m + 1 < chain.size(); ++m) {
        for (std::size_t l = m + 1; l < chain.size(); ++l) {
          Limb one = chain.Choose(shape, u, m, l);
          Limb other = mirrored == nullptr ? one : mirrored->Choose(shape, u, m, l);
          if (one.score() + other.score() + 2 * kBendingShare <= best_score) continue;
          chain.AddBending(one);
          mirrored == nullptr ? chain.AddBending(other) : mirrored->AddBending(other);
          // Of joints in one place, the names decide; without names, the last one moves the bone.
          const double score = one.score() + other.score() + 1e-4 * static_cast<double>(u + m + l);
          if (score <= best_score) continue;
          best_score = score;
          first = one;
          if (second != nullptr) *second = other;
        }
      }
    }
  };
  if (is_same) {
    fit(a, &b, best[0], &best[1]);
  } else {
    fit(a, nullptr, best[0], nullptr);
    fit(b, nullptr, best[1], nullptr);
  }
  if (best[0].upper >= 0) a.FindEnds(shape, best[0]);
  if (best[1].upper >= 0) b.FindEnds(shape, best[1]);
  return best;
}

double Similarity(double a, double b) {
  return std::max(a, b) > 0 ? std::min(a, b) / std::max(a, b) : 1;
}

double SymmetryOf(const Limb& a, const Limb& b) {
  return std::min({Similarity(a.upper_length, b.upper_length),
                   Similarity(a.lower_length, b.lower_length),
                   Similarity(a.length() + a.before, b.length() + b.before)});
}

// Returns the side that most names of a chain tell.
Side SideOf(const BoneTree& tree, std::span<const int> chain) {
  int balance = 0;
  for (const int joint : chain) {
    if (tree.meaning(joint).side == Side::kLeft) ++balance;
    if (tree.meaning(joint).side == Side::kRight) --balance;
  }
  if (balance == 0) return Side::kNone;
  return balance > 0 ? Side::kLeft : Side::kRight;
}

}  // namespace

std::vector<LimbPair> FindLimbPairs(const BoneTree& tree) {
  double longest = 0;
  for (int j = 0; j < tree.count(); ++j) longest = std::max(longest, tree.reach(j));
  std::vector<LimbPair> pairs;
  for (int branching = 0; branching < tree.count(); ++branching) {
    std::vector<int> roots;
    for (const int child : tree.children(branching)) {
      if (tree.reach(child) >= kMinShareOfReach * longest) roots.push_back(child);
    }
    if (roots.size() > 12) continue;  // a crowd of props or markers
    std::vector<LimbChain> chains;
    chains.reserve(roots.size());
    for (const int root : roots) chains.emplace_back(tree, root);
    for (std::size_t i = 0; i < roots.size(); ++i) {
      for (std::size_t k = i + 1; k < roots.size(); ++k) {
        const Side side_i = SideOf(tree, chains[i].joints());
        const Side side_k = SideOf(tree, chains[k].joints());
        if (side_i == side_k && side_i != Side::kNone) continue;
        if ((side_i == Side::kNone) != (side_k == Side::kNone)) continue;
        LimbPair pair{.branching = branching, .roots = {roots[i], roots[k]}};
        pair.as_legs = FitLimbs(kLeg, chains[i], chains[k]);
        pair.as_arms = FitLimbs(kArm, chains[i], chains[k]);
        if (pair.as_legs[0].upper < 0 || pair.as_legs[1].upper < 0) continue;
        if (side_i == Side::kRight) {
          std::swap(pair.roots[0], pair.roots[1]);
          std::swap(pair.as_legs[0], pair.as_legs[1]);
          std::swap(pair.as_arms[0], pair.as_arms[1]);
        }
        pair.symmetry = std::max(SymmetryOf(pair.as_legs[0], pair.as_legs[1]),
                                 SymmetryOf(pair.as_arms[0], pair.as_arms[1]));
        if (pair.symmetry >= kMinSymmetry) pairs.push_back(pair);
      }
    }
  }
  std::ranges::stable_sort(pairs, std::ranges::greater(), [](const LimbPair& pair) {
    return std::max(pair.leg_score(), pair.arm_score());
  });
  if (pairs.size() > kMaxPairs) pairs.resize(kMaxPairs);
  return pairs;
}

}  // namespace motiondb::core
