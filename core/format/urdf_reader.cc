#include "core/format/urdf_reader.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>

#include "core/format/gunzip.h"
#include "core/format/text_scanner.h"
#include "core/format/urdf_file.h"
#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"

namespace motiondb::core {
namespace {

// A humanoid with two hands has about a hundred; the cost of a pose is cubic in this number.
constexpr int kMaxDofs = 300;

using Type = UrdfJoint::Type;

bool HasOneDof(Type type) {
  return type == Type::kRevolute || type == Type::kContinuous || type == Type::kPrismatic;
}

// Returns the degrees of freedom. `pre`: from the joint's frame to the parent's, because the
// skeleton's translations are in the parent's frame.
std::vector<Dof> Dofs(const UrdfJoint& joint, const Eigen::Matrix3d& pre) {
  const auto slide = [&](const Eigen::Vector3d& axis) {
    return Dof{.kind = Dof::Kind::kTranslation, .axis = (pre * axis).normalized()};
  };
  const auto turn = [](const Eigen::Vector3d& axis) {
    return Dof{.kind = Dof::Kind::kRotation, .axis = axis};
  };
  const auto limited = [&](Dof dof) {
    dof.lower = joint.lower;
    dof.upper = joint.upper;
    return dof;
  };
  using Eigen::Vector3d;
  switch (joint.type) {
    case Type::kRevolute:
      return {limited(turn(joint.axis))};
    case Type::kContinuous:
      return {turn(joint.axis)};
    case Type::kPrismatic:
      return {limited(slide(joint.axis))};
    case Type::kFixed:
      return {};
    case Type::kFloating:
      return {slide(Vector3d::UnitX()), slide(Vector3d::UnitY()), slide(Vector3d::UnitZ()),
              turn(Vector3d::UnitZ()),  turn(Vector3d::UnitY()),  turn(Vector3d::UnitX())};
    case Type::kPlanar: {
      const auto plane = ShortestTurn(Vector3d::UnitZ(), joint.axis);
      return {slide(plane * Vector3d::UnitX()), slide(plane * Vector3d::UnitY()), turn(joint.axis)};
    }
  }
  return {};
}

// Converts a URDF joint to a skeleton joint.
Joint ToJoint(const UrdfJoint& urdf, int parent) {
  Joint joint{.name = urdf.name, .parent = parent, .offset_m = urdf.origin.xyz_m, .dofs = {}};
  joint.pre_rotation = FromRollPitchYaw(urdf.origin.rpy_rad);
  joint.dofs = Dofs(urdf, joint.pre_rotation);
  return joint;
}

// Takes the joint's one degree of freedom and leaves it at `value`.
void Hold(Joint& joint, double value) {
  const Dof dof = joint.dofs[0];
  joint.dofs.clear();
  if (dof.kind == Dof::Kind::kTranslation) {
    joint.offset_m += value * dof.axis;
  } else {
    joint.pre_rotation *= Eigen::AngleAxisd(value, dof.axis).toRotationMatrix();
  }
}

class RobotBuilder {
 public:
  RobotBuilder(SourceFile file, UrdfFile urdf) : file_(file), urdf_(std::move(urdf)) {}

  absl::StatusOr<UrdfRobot> Build() {
    MOTIONDB_RETURN_IF_ERROR(IndexNames());
    MOTIONDB_RETURN_IF_ERROR(ConnectLinks());
    MOTIONDB_RETURN_IF_ERROR(FindRoot());
    MOTIONDB_RETURN_IF_ERROR(ResolveMimics());
    MakeJoints();
    for (std::size_t j = 0; j < urdf_.joints.size(); ++j) {
      if (placed_[j]) continue;
      return Error(urdf_.joints[j].line, "expected a tree of links, found joint '{}' in a cycle",
                   Shown(urdf_.joints[j].name));
    }
    NoteMimics();
    NoteVisualErrors();
    auto skeleton = Skeleton::Create(urdf_.name.empty() ? "robot" : urdf_.name, std::move(joints_));
    if (!skeleton.ok()) {
      return InvalidArgument("{}: expected a skeleton: {}", file_.name,
                             std::string(skeleton.status().message()));
    }
    if (skeleton->dof_count() > kMaxDofs) {
      return InvalidArgument("{}: expected at most {} degrees of freedom, found {}", file_.name,
                             kMaxDofs, skeleton->dof_count());
    }
    report_.unit_provenance = Provenance::kStated;
    report_.up_axis = UpAxis::kZ;
    report_.up_provenance = Provenance::kStated;
    RobotDynamics dynamics = Dynamics(*skeleton);
    return UrdfRobot{*std::move(skeleton), std::move(mimics_), std::move(dynamics), Visuals(),
                     std::move(report_)};
  }

 private:
  using Index = std::unordered_map<std::string, int>;

  template <typename... Args>
  absl::Status Error(int line, fmt::format_string<Args...> format, Args&&... args) const {
    return InvalidArgument("{}:{}: {}", file_.name, line,
                           fmt::format(format, std::forward<Args>(args)...));
  }

  template <typename Part>
  absl::Status IndexPart(std::string_view kind, const std::vector<Part>& parts,
                         Index& index) const {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (index.emplace(parts[i].name, static_cast<int>(i)).second) continue;
      return Error(parts[i].line, "expected {}s of different names, found '{}' twice", kind,
                   Shown(parts[i].name));
    }
    return absl::OkStatus();
  }

  absl::Status IndexNames() {
    if (urdf_.links.empty()) {
      return InvalidArgument("{}: expected at least one <link>, found none", file_.name);
    }
    MOTIONDB_RETURN_IF_ERROR(IndexPart("link", urdf_.links, links_));
    return IndexPart("joint", urdf_.joints, joint_index_);
  }

  absl::StatusOr<int> Link(const UrdfJoint& joint, const std::string& name) const {
    if (const auto at = links_.find(name); at != links_.end()) return at->second;
    return Error(joint.line, "joint '{}': expected the name of a link, found '{}'",
                 Shown(joint.name), Shown(name));
  }

  // Finds the parent joint and the child joints of each link.
  absl::Status ConnectLinks() {
    carrier_.assign(urdf_.links.size(), -1);
    carried_.resize(urdf_.links.size());
    for (std::size_t j = 0; j < urdf_.joints.size(); ++j) {
      const UrdfJoint& joint = urdf_.joints[j];
      MOTIONDB_ASSIGN_OR_RETURN(const int parent, Link(joint, joint.parent));
      MOTIONDB_ASSIGN_OR_RETURN(const int child, Link(joint, joint.child));
      if (carrier_[child] >= 0) {
        return Error(
            joint.line, "expected link '{}' to be the child of one joint, found '{}' and '{}'",
            Shown(joint.child), Shown(urdf_.joints[carrier_[child]].name), Shown(joint.name));
      }
      carrier_[child] = static_cast<int>(j);
      child_link_.push_back(child);
      carried_[parent].push_back(static_cast<int>(j));
    }
    return absl::OkStatus();
  }

  absl::Status FindRoot() {
    for (std::size_t link = 0; link < urdf_.links.size(); ++link) {
      if (carrier_[link] >= 0) continue;
      if (root_ >= 0) {
        return Error(urdf_.links[link].line,
                     "expected one link without a joint above it, found '{}' and '{}'",
                     Shown(urdf_.links[root_].name), Shown(urdf_.links[link].name));
      }
      root_ = static_cast<int>(link);
    }
    if (root_ >= 0) return absl::OkStatus();
    return Error(urdf_.links[0].line, "expected a root link, found a cycle of links");
  }

  // Replaces each mimic joint's master by the end of its chain of masters. O(joints).
  absl::Status ResolveMimics() {
    std::vector<bool> resolved(urdf_.joints.size(), false);
    std::vector<bool> on_chain(urdf_.joints.size(), false);
    std::vector<int> chain;
    for (std::size_t j = 0; j < urdf_.joints.size(); ++j) {
      int at = static_cast<int>(j);
      while (urdf_.joints[at].mimic && !resolved[at]) {
        const UrdfJoint& joint = urdf_.joints[at];
        if (on_chain[at]) {
          return Error(joint.line, "expected no cycle of mimic joints, found one at '{}'",
                       Shown(joint.name));
        }
        on_chain[at] = true;
        chain.push_back(at);
        const auto master = joint_index_.find(joint.mimic->master);
        if (master == joint_index_.end() || !HasOneDof(urdf_.joints[master->second].type) ||
            !HasOneDof(joint.type)) {
          return Error(joint.line,
                       "joint '{}': expected it and the joint that it mimics to be revolute, "
                       "continuous or prismatic, found '{}'",
                       Shown(joint.name), Shown(joint.mimic->master));
        }
        at = master->second;
      }
      for (; !chain.empty(); chain.pop_back()) {
        UrdfMimic& mimic = *urdf_.joints[chain.back()].mimic;
        if (const auto& above = urdf_.joints[joint_index_.at(mimic.master)].mimic) {
          mimic.master = above->master;
          mimic.offset += mimic.multiplier * above->offset;
          mimic.multiplier *= above->multiplier;
        }
        if (!std::isfinite(mimic.offset) || !std::isfinite(mimic.multiplier)) {
          return Error(urdf_.joints[chain.back()].line,
                       "joint '{}': expected a chain of mimic joints with finite products",
                       Shown(urdf_.joints[chain.back()].name));
        }
        resolved[chain.back()] = true;
      }
    }
    return absl::OkStatus();
  }

  // Creates the joints depth first. Not recursive: chain length does not use stack.
  void MakeJoints() {
    placed_.assign(urdf_.joints.size(), false);
    std::vector<std::pair<int, int>> open;  // joint of the file, parent in the skeleton
    const auto open_all = [&](int link, int parent) {
      const std::vector<int>& below = carried_[link];
      for (auto j = below.rbegin(); j != below.rend(); ++j) open.emplace_back(*j, parent);
    };
    open_all(MakeBase(), 0);
    while (!open.empty()) {
      const auto [j, parent] = open.back();
      open.pop_back();
      placed_[j] = true;
      const UrdfJoint& urdf = urdf_.joints[j];
      joints_.push_back(ToJoint(urdf, parent));
      moved_links_.push_back(child_link_[j]);
      sources_.push_back(j);
      if (urdf.mimic) {
        Hold(joints_.back(), urdf.mimic->offset);
        mimics_.push_back(
            {urdf.name, urdf.mimic->master, urdf.mimic->multiplier, urdf.mimic->offset});
      }
      open_all(child_link_[j], static_cast<int>(joints_.size()) - 1);
    }
  }

  // Adds the floating base and returns its link.
  int MakeBase() {
    UrdfJoint base{.type = Type::kFloating, .mimic = {}};
    int link = root_;
    if (carried_[root_].size() == 1 && urdf_.joints[carried_[root_][0]].type == Type::kFloating) {
      const int floating = carried_[root_][0];
      base = urdf_.joints[floating];
      link = child_link_[floating];
      placed_[floating] = true;
      report_.notes.push_back(fmt::format("link '{}' is the world, joint '{}' is the base",
                                          Shown(urdf_.links[root_].name), Shown(base.name)));
    }
    UniqueNames names;
    for (const UrdfJoint& joint : urdf_.joints) names.Add(joint.name);
    const std::string& requested = urdf_.links[link].name;
    base.name = names.Add(requested);
    if (base.name != requested) {
      report_.notes.push_back(fmt::format("the base is named '{}', because a joint is named '{}'",
                                          Shown(base.name), Shown(requested)));
    }
    joints_.push_back(ToJoint(base, -1));
    moved_links_.push_back(link);
    sources_.push_back(-1);
    return link;
  }

  // Returns motors and masses in the order of the skeleton's joints. A mimic joint limits the speed
  // of its master.
  RobotDynamics Dynamics(const Skeleton& skeleton) const {
    RobotDynamics dynamics;
    dynamics.max_speeds =
        Eigen::RowVectorXd::Constant(skeleton.dof_count(), std::numeric_limits<double>::infinity());
    dynamics.max_efforts = dynamics.max_speeds;
    for (int j = 0; j < skeleton.joint_count(); ++j) {
      dynamics.links.push_back(urdf_.links[moved_links_[j]].inertia);
      if (sources_[j] < 0) continue;
      const UrdfJoint& urdf = urdf_.joints[sources_[j]];
      const bool mimics = urdf.mimic.has_value();
      const int joint = mimics ? skeleton.FindJoint(urdf.mimic->master) : j;
      if (skeleton.joints()[joint].dofs.size() != 1) continue;
      const int column = skeleton.first_dof(joint);
      const double ratio = mimics ? std::abs(urdf.mimic->multiplier) : 1;
      if (ratio > 0) {
        dynamics.max_speeds[column] = std::min(dynamics.max_speeds[column], urdf.max_speed / ratio);
      }
      if (!mimics) dynamics.max_efforts[column] = urdf.max_effort;
    }
    return dynamics;
  }

  // Returns the shapes in the order of the skeleton's joints.
  std::vector<LinkVisual> Visuals() const {
    std::vector<LinkVisual> visuals;
    for (std::size_t j = 0; j < moved_links_.size(); ++j) {
      for (const LinkVisual& visual : urdf_.links[moved_links_[j]].visuals) {
        visuals.push_back(visual);
        visuals.back().joint = static_cast<int>(j);
      }
    }
    return visuals;
  }

  void NoteVisualErrors() {
    if (urdf_.invalid_visual_links == 0) return;
    report_.notes.push_back(
        fmt::format("visual shapes of {} link{} are left out: {}", urdf_.invalid_visual_links,
                    urdf_.invalid_visual_links == 1 ? "" : "s", urdf_.first_visual_error));
  }

  void NoteMimics() {
    constexpr std::size_t kShown = 3;
    if (mimics_.empty()) return;
    std::string names;
    for (std::size_t i = 0; i < std::min(kShown, mimics_.size()); ++i) {
      names += (i == 0 ? "" : ", ") + Shown(mimics_[i].joint);
    }
    if (mimics_.size() > kShown) names += fmt::format(" and {} more", mimics_.size() - kShown);
    report_.notes.push_back("mimic joints rest at their offsets: " + names);
  }

  SourceFile file_;
  UrdfFile urdf_;
  Index links_;
  Index joint_index_;
  std::vector<int> carrier_;               // of a link: its parent joint, or -1
  std::vector<std::vector<int>> carried_;  // of a link: its child joints
  std::vector<int> child_link_;            // of a joint
  int root_ = -1;                          // the link without a parent joint
  std::vector<bool> placed_;               // of a joint: in the skeleton or its base
  std::vector<Joint> joints_;
  std::vector<int> moved_links_;  // of each joint of the skeleton
  std::vector<int> sources_;      // of each joint of the skeleton: the file's joint; -1: the base
  std::vector<MimicJoint> mimics_;
  SourceReport report_;
};

}  // namespace

absl::StatusOr<UrdfRobot> ReadUrdf(SourceFile file) {
  std::string plain;
  MOTIONDB_ASSIGN_OR_RETURN(file, PlainFile(file, kMaxSkeletonBytes, plain));
  MOTIONDB_ASSIGN_OR_RETURN(UrdfFile urdf, ReadUrdfFile(file));
  return RobotBuilder(file, std::move(urdf)).Build();
}

}  // namespace motiondb::core
