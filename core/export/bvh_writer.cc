#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <span>
#include <string_view>
#include <vector>

#include "core/export/file_bytes.h"
#include "core/export/writers.h"
#include "core/format/conventions.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"

namespace motiondb::core {

namespace {

constexpr double kCentimetresPerMetre = 100;
constexpr int kMaxIndent = 40;  // bounds the line length for deep chains

// An order of the three rotation channels; the rightmost is applied first.
struct RotationOrder {
  std::string_view channels;
  std::array<int, 3> axes;  // 0 x, 1 y, 2 z
};

constexpr std::array<RotationOrder, 2> kOrders = {{
    {"Zrotation Xrotation Yrotation", {2, 0, 1}},
    {"Zrotation Yrotation Xrotation", {2, 1, 0}},
}};

// A joint of the file, in file order.
struct BvhNode {
  int joint = -1;
  int depth = 0;
  std::string name;
  bool is_end_site = false;
  bool is_leaf = false;
  bool moves = false;  // has position channels
  const RotationOrder* order = nullptr;
};

bool Slides(const Joint& joint) {
  return std::any_of(joint.dofs.begin(), joint.dofs.end(),
                     [](const Dof& dof) { return dof.kind == Dof::Kind::kTranslation; });
}

// Avoids "-0.00000000" in the output.
double Plain(double value) { return std::abs(value) < 5e-9 ? 0 : value; }

std::string SafeName(std::string_view name) {
  std::string safe;
  for (const char c : name) {
    const bool blank = static_cast<unsigned char>(c) <= ' ' || c == '\x7f';
    safe += blank || c == '{' || c == '}' ? '_' : c;
  }
  return safe;
}

// Returns the joints depth first, children in the skeleton's order.
std::vector<BvhNode> DepthFirst(const Skeleton& skeleton) {
  const std::vector<Joint>& joints = skeleton.joints();
  std::vector<std::vector<int>> children(joints.size());
  std::vector<std::pair<int, int>> open;  // joint and depth
  for (int j = skeleton.joint_count(); j-- > 0;) {
    if (joints[j].parent < 0) {
      open.emplace_back(j, 0);
    } else {
      children[joints[j].parent].push_back(j);
    }
  }
  std::vector<BvhNode> nodes;
  UniqueNames names;
  while (!open.empty()) {
    const auto [j, depth] = open.back();
    open.pop_back();
    const Joint& joint = joints[j];
    BvhNode node{.joint = j, .depth = depth, .name = names.Add(SafeName(joint.name))};
    node.is_leaf = children[j].empty();
    node.is_end_site = node.is_leaf && joint.dofs.empty() && joint.parent >= 0 &&
                       children[joint.parent].size() == 1 &&
                       joint.name == joints[joint.parent].name + "_end";
    node.moves = joint.parent < 0 || Slides(joint);
    nodes.push_back(std::move(node));
    for (const int child : children[j]) open.emplace_back(child, depth + 1);
  }
  return nodes;
}

// Roots are written with y up, all other joints in their parents' frames.
class BvhWriter {
 public:
  explicit BvhWriter(const JointMotion& motion)
      : motion_(motion),
        file_from_world_(WorldFromFile(UpAxis::kY).transpose()),
        nodes_(DepthFirst(*motion.skeleton)) {
    for (BvhNode& node : nodes_) node.order = &ChooseOrder(node.joint);
  }

  std::string Write() {
    text_ = "HIERARCHY\n";
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      WriteOpening(nodes_[i]);
      const int next_depth = i + 1 < nodes_.size() ? nodes_[i + 1].depth : 0;
      for (int depth = nodes_[i].depth; depth >= next_depth; --depth) Line(depth, "}}");
    }
    fmt::format_to(std::back_inserter(text_), "MOTION\nFrames: {}\nFrame Time: {:.12f}\n",
                   motion_.angles.rows(), 1 / motion_.frame_rate_hz);
    std::vector<Eigen::Vector3d> previous(nodes_.size(), Eigen::Vector3d::Zero());
    for (Eigen::Index frame = 0; frame < motion_.angles.rows(); ++frame) {
      const std::size_t begin = text_.size();
      WriteFrame(frame, previous);
      if (frame == 0) ReserveFrames(text_, text_.size() - begin, motion_.angles.rows() - 1);
    }
    return std::move(text_);
  }

 private:
  const Joint& JointOf(const BvhNode& node) const { return motion_.skeleton->joints()[node.joint]; }

  // Returns the joint's transform to its parent's frame, or a root's to the file's, in metres.
  Eigen::Isometry3d Local(int j, Eigen::Index frame) const {
    const Joint& joint = motion_.skeleton->joints()[j];
    const std::span<const double> row(motion_.angles.data() + frame * motion_.angles.cols(),
                                      static_cast<std::size_t>(motion_.angles.cols()));
    const Eigen::Isometry3d local =
        ParentFromJoint(joint, row.subspan(motion_.skeleton->first_dof(j), joint.dofs.size()));
    return joint.parent < 0 ? Eigen::Isometry3d(file_from_world_) * local : local;
  }

  // Gimbal lock: the first and last axis become parallel. Chooses the order further from it.
  const RotationOrder& ChooseOrder(int joint) const {
    std::array<double, 2> nearest_lock = {0, 0};  // maximum cosine between the two axes
    for (Eigen::Index frame = 0; frame < motion_.angles.rows(); ++frame) {
      const Eigen::Matrix3d rotation = Local(joint, frame).linear();
      for (std::size_t i = 0; i < kOrders.size(); ++i) {
        const double cosine = std::abs(rotation(kOrders[i].axes[0], kOrders[i].axes[2]));
        nearest_lock[i] = std::max(nearest_lock[i], cosine);
      }
    }
    return nearest_lock[1] < nearest_lock[0] ? kOrders[1] : kOrders[0];
  }

  Eigen::Vector3d OffsetCm(const Joint& joint) const {
    const Eigen::Vector3d offset = kCentimetresPerMetre * joint.offset_m;
    return joint.parent < 0 ? Eigen::Vector3d(file_from_world_ * offset) : offset;
  }

  template <typename... Args>
  void Line(int depth, fmt::format_string<Args...> format, Args&&... args) {
    text_.append(static_cast<std::size_t>(std::min(depth, kMaxIndent)), '\t');
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
    text_ += '\n';
  }

  void WriteOffset(int depth, const Eigen::Vector3d& cm) {
    Line(depth, "OFFSET {:.8f} {:.8f} {:.8f}", Plain(cm.x()), Plain(cm.y()), Plain(cm.z()));
  }

  // Writes a node without its children and closing brace.
  void WriteOpening(const BvhNode& node) {
    const Joint& joint = JointOf(node);
    if (node.is_end_site) {
      Line(node.depth, "End Site");
    } else {
      Line(node.depth, "{} {}", joint.parent < 0 ? "ROOT" : "JOINT", node.name);
    }
    Line(node.depth, "{{");
    WriteOffset(node.depth + 1, OffsetCm(joint));
    if (node.is_end_site) return;
    Line(node.depth + 1, "CHANNELS {}{}", node.moves ? "6 Xposition Yposition Zposition " : "3 ",
         node.order->channels);
    if (node.is_leaf) WriteDefaultEnd(node.depth + 1, OffsetCm(joint));
  }

  // Importers draw a bone from a joint to its end site; a bone of zero length would be invisible.
  void WriteDefaultEnd(int depth, const Eigen::Vector3d& joint_offset_cm) {
    const bool has_direction = joint_offset_cm.norm() > 1e-3;
    Line(depth, "End Site");
    Line(depth, "{{");
    WriteOffset(depth + 1,
                has_direction ? Eigen::Vector3d(0.5 * joint_offset_cm) : Eigen::Vector3d::UnitY());
    Line(depth, "}}");
  }

  void WriteFrame(Eigen::Index frame, std::vector<Eigen::Vector3d>& previous) {
    const char* separator = "";
    const auto write = [&](const Eigen::Vector3d& values) {
      fmt::format_to(std::back_inserter(text_), "{}{:.8f} {:.8f} {:.8f}", separator,
                     Plain(values[0]), Plain(values[1]), Plain(values[2]));
      separator = " ";
    };
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const BvhNode& node = nodes_[i];
      if (node.is_end_site) continue;
      const Eigen::Isometry3d local = Local(node.joint, frame);
      if (node.moves) write(kCentimetresPerMetre * local.translation());
      const std::array<Eigen::Vector3d, 3> axes = {Eigen::Vector3d::Unit(node.order->axes[0]),
                                                   Eigen::Vector3d::Unit(node.order->axes[1]),
                                                   Eigen::Vector3d::Unit(node.order->axes[2])};
      previous[i] = AnglesAboutAxes(local.linear(), axes, previous[i]);
      write(previous[i] / kRadiansPerDegree);
    }
    text_ += '\n';
  }

  const JointMotion& motion_;
  Eigen::Matrix3d file_from_world_;
  std::vector<BvhNode> nodes_;
  std::string text_;
};

}  // namespace

std::vector<std::string> BvhNames(const Skeleton& skeleton) {
  std::vector<std::string> names(skeleton.joints().size());
  for (BvhNode& node : DepthFirst(skeleton)) names[node.joint] = std::move(node.name);
  return names;
}

absl::StatusOr<std::string> WriteBvh(const JointMotion& motion) {
  MOTIONDB_RETURN_IF_ERROR(CheckWritable("BVH", motion));
  return BvhWriter(motion).Write();
}

absl::Status CheckWritable(std::string_view format, const JointMotion& motion) {
  if (motion.skeleton == nullptr) {
    return InvalidArgument("{}: the motion has no skeleton", format);
  }
  if (motion.angles.rows() == 0) return InvalidArgument("{}: the motion has no frame", format);
  if (!IsFrameRate(motion.frame_rate_hz)) {
    return InvalidArgument("{}: expected a frame rate from 0.001 to 100000 Hz, found {}", format,
                           motion.frame_rate_hz);
  }
  if (motion.angles.cols() != motion.skeleton->dof_count()) {
    return InvalidArgument("{}: expected {} columns, one a degree of freedom, found {}", format,
                           motion.skeleton->dof_count(), motion.angles.cols());
  }
  for (Eigen::Index frame = 0; frame < motion.angles.rows(); ++frame) {
    if (!motion.angles.row(frame).allFinite()) {
      return InvalidArgument("{}: frame {} has a joint angle that is not finite", format, frame);
    }
  }
  return absl::OkStatus();
}

}  // namespace motiondb::core
