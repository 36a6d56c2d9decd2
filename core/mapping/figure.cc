#include "core/mapping/figure.h"

#include <algorithm>
#include <cmath>

#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"

namespace motiondb::core {
namespace {

// Lowest mean cosine that decides which side is left.
constexpr double kMinSideEvidence = 0.25;

using Frame = Eigen::Matrix3Xd;

Eigen::Vector3d Lateral(const Figure& figure, Role role, const Frame& frame) {
  return frame.col(figure.at(role, Side::kLeft).index) -
         frame.col(figure.at(role, Side::kRight).index);
}

double Cosine(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double product = a.norm() * b.norm();
  return product > 0 ? a.dot(b) / product : 0;
}

// Mean over frames; frames with missing points do not count.
template <typename Value>
double MeanOver(const PointCloud& points, const Value& value) {
  double sum = 0;
  int count = 0;
  for (const Frame& frame : points.frames) {
    const double v = value(frame);
    if (!std::isfinite(v)) continue;
    sum += v;
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

void SwapSides(Figure& figure, std::initializer_list<Role> roles) {
  for (const Role role : roles) {
    auto& sides = figure.points[static_cast<std::size_t>(role)];
    std::swap(sides[0], sides[1]);
  }
}
void SwapArms(Figure& figure) {
  SwapSides(figure, {Role::kClavicle, Role::kShoulder, Role::kElbow, Role::kWrist, Role::kHand});
}
void SwapLegs(Figure& figure) {
  SwapSides(figure,
            {Role::kHip, Role::kKnee, Role::kAnkle, Role::kHeel, Role::kToe, Role::kToeTip});
}

// Returns -1 to 1: above 0 if the left side of the figure is on the left of the direction in which
// feet point and knees bend. Left = up x forward in right-handed axes, whichever axis is up.
double LeftEvidence(const PointCloud& points, const Figure& figure) {
  return MeanOver(points, [&](const Frame& frame) {
    const auto at = [&](Role role, Side side) -> Eigen::Vector3d {
      return frame.col(figure.at(role, side).index);
    };
    const Eigen::Vector3d hips = (at(Role::kHip, Side::kLeft) + at(Role::kHip, Side::kRight)) / 2;
    const Eigen::Vector3d shoulders =
        (at(Role::kShoulder, Side::kLeft) + at(Role::kShoulder, Side::kRight)) / 2;
    const Eigen::Vector3d up = shoulders - hips;
    const Eigen::Vector3d lateral = Lateral(figure, Role::kHip, frame);
    double sum = 0;
    double weight = 0;
    for (const Side side : {Side::kLeft, Side::kRight}) {
      const Eigen::Vector3d hip = at(Role::kHip, side);
      const Eigen::Vector3d knee = at(Role::kKnee, side);
      const Eigen::Vector3d ankle = at(Role::kAnkle, side);
      const double leg = (knee - hip).norm() + (ankle - knee).norm();
      const Role tip = figure.at(Role::kToe, side).is_found() ? Role::kToe : Role::kToeTip;
      if (figure.at(tip, side).is_found()) {
        // Only the part of the foot that is perpendicular to the shank points to the front.
        const Eigen::Vector3d shank = (ankle - knee).normalized();
        Eigen::Vector3d foot = at(tip, side) - ankle;
        foot -= foot.dot(shank) * shank;
        if (foot.norm() > 0.04 * leg) {
          sum += Cosine(up.cross(foot), lateral);
          weight += 1;
        }
      }
      const Eigen::Vector3d line = (ankle - hip).normalized();
      const Eigen::Vector3d bend = (knee - hip) - (knee - hip).dot(line) * line;
      if (bend.norm() > 0.06 * leg) {
        sum += 0.5 * Cosine(up.cross(bend), lateral);
        weight += 0.5;
      }
    }
    return weight > 0 ? sum / weight : std::nan("");
  });
}

// Returns the first point whose name tells the other side; empty if there is none.
std::string PointOfOtherSide(const std::vector<NameMeaning>& meanings, const Figure& figure) {
  for (std::size_t r = static_cast<std::size_t>(Role::kHip); r < kRoleCount; ++r) {
    for (const Side side : {Side::kLeft, Side::kRight}) {
      const RolePoint& point = figure.at(static_cast<Role>(r), side);
      if (!point.is_found()) continue;
      const Side named = meanings[point.index].side;
      if (named != Side::kNone && named != side) return figure.names[point.index];
    }
  }
  return "";
}

void CheckSides(const PointCloud& points, const std::vector<NameMeaning>& meanings,
                Figure& figure) {
  const auto named = [&](Role role) {
    return meanings[figure.at(role, Side::kLeft).index].side != Side::kNone;
  };
  const bool legs_named = named(Role::kHip) || named(Role::kKnee);
  const bool arms_named = named(Role::kShoulder) || named(Role::kElbow);
  // Over a clip, arms are on the side of their legs.
  const double same_side = MeanOver(points, [&](const Frame& frame) {
    return Cosine(Lateral(figure, Role::kHip, frame), Lateral(figure, Role::kShoulder, frame));
  });
  if (same_side < 0) {
    if (legs_named && arms_named) {
      figure.problem =
          "the names of sides contradict the figure: left arm and left leg are on different sides";
      return;
    }
    arms_named ? SwapLegs(figure) : SwapArms(figure);
  }
  const double evidence = LeftEvidence(points, figure);
  if (!legs_named && !arms_named) {
    if (std::abs(evidence) < kMinSideEvidence) {
      figure.problem =
          "left and right are unknown: neither names nor the direction of feet show them";
    } else if (evidence < 0) {
      SwapLegs(figure);
      SwapArms(figure);
    }
    return;
  }
  if (evidence < -kMinSideEvidence) {
    figure.problem =
        "the names of sides contradict the figure: its feet and knees point as if left and right "
        "were exchanged; the file may be mirrored";
  } else if (const std::string name = PointOfOtherSide(meanings, figure); !name.empty()) {
    figure.problem =
        fmt::format("the names of sides contradict the figure: '{}' is on the other side", name);
  }
}

}  // namespace

bool IsComplete(const Figure& figure) {
  for (const Role role : kNecessaryRoles) {
    for (const Side side : {Side::kLeft, Side::kRight}) {
      if (!figure.at(role, side).is_found()) return false;
    }
  }
  return true;
}

PointCloud SamplePoints(const Motion& motion, int max_frames) {
  PointCloud cloud;
  const auto for_samples = [&](Eigen::Index frames, const auto& add) {
    const Eigen::Index count = std::min<Eigen::Index>(max_frames, frames);
    for (Eigen::Index i = 0; i < count; ++i) add(count > 1 ? i * (frames - 1) / (count - 1) : 0);
  };
  if (const auto* markers = std::get_if<MarkerMotion>(&motion)) {
    cloud.names = markers->names;
    for_samples(markers->positions_m.rows(), [&](Eigen::Index t) {
      const Eigen::RowVectorXd row = markers->positions_m.row(t).cast<double>();
      cloud.frames.emplace_back(Eigen::Map<const Frame>(row.data(), 3, cloud.count()));
    });
    return cloud;
  }
  const JointMotion& joints = std::get<JointMotion>(motion);
  for (const Joint& joint : joints.skeleton->joints()) {
    cloud.names.push_back(joint.name);
    cloud.parents.push_back(joint.parent);
  }
  std::vector<Eigen::Isometry3d> pose(cloud.names.size());
  for_samples(joints.angles.rows(), [&](Eigen::Index t) {
    ForwardKinematics(*joints.skeleton, joints.angles.row(t), pose);
    Frame& frame = cloud.frames.emplace_back(3, cloud.count());
    auto& rotations = cloud.rotations.emplace_back();
    for (int j = 0; j < cloud.count(); ++j) {
      frame.col(j) = pose[j].translation();
      rotations.push_back(pose[j].linear());
    }
  });
  return cloud;
}

Figure FindFigure(const PointCloud& points) {
  const std::vector<NameMeaning> meanings = NameMeanings(points.names);
  Figure figure;
  if (!points.parents.empty() && !points.frames.empty()) {
    if (auto found = FindInHierarchy(points, meanings)) figure = *std::move(found);
  }
  if (!IsComplete(figure)) figure = FindByNames(points, meanings);
  if (!IsComplete(figure) || points.frames.empty()) {
    figure.problem = "no figure of a person: legs and arms were not found";
    return figure;
  }
  CheckSides(points, meanings, figure);
  return figure;
}

Figure FindByNames(const PointCloud& points, const std::vector<NameMeaning>& meanings) {
  struct Choice {
    float fit;
    int point;
    Role role;
  };
  constexpr float kMinFit = 0.4F;
  std::vector<Choice> choices;
  for (int p = 0; p < points.count(); ++p) {
    for (std::size_t r = 0; r < kRoleCount; ++r) {
      const float fit = meanings[p].fit[r];
      if (fit >= kMinFit) choices.push_back({fit, p, static_cast<Role>(r)});
    }
  }
  // The best names first; of equal ones, the first in the file.
  std::ranges::stable_sort(choices, std::ranges::greater(), &Choice::fit);
  Figure figure;
  figure.names = points.names;
  std::vector<bool> is_used(points.count(), false);
  for (const Choice& choice : choices) {
    const Side side = meanings[choice.point].side;
    const bool is_sided = choice.role >= Role::kHip;
    if (is_sided != (side != Side::kNone) || is_used[choice.point]) continue;
    RolePoint& point = figure.at(choice.role, side);
    if (choice.role == Role::kSpine) {
      figure.spine.push_back(choice.point);
    } else if (point.is_found()) {
      continue;
    }
    point = {choice.point, 0.9 * choice.fit};
    is_used[choice.point] = true;
  }
  std::ranges::sort(figure.spine);
  return figure;
}

}  // namespace motiondb::core
