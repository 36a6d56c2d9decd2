#include <Eigen/Geometry>
#include <cmath>
#include <iterator>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/export/file_bytes.h"
#include "core/export/writers.h"
#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"

namespace motiondb::core {
namespace {

constexpr std::string_view kPoseColumns[] = {"time_s",  "root_x_m", "root_y_m", "root_z_m",
                                             "root_qx", "root_qy",  "root_qz",  "root_qw"};

// A column of joint values: factor * (a degree of freedom) + offset.
struct Column {
  std::string name;
  int dof = 0;
  double factor = 1;
  double offset = 0;
};

using MimicIndex = std::unordered_map<std::string_view, const MimicJoint*>;

std::string Field(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == text.npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string_view("\"\"") : std::string_view(&c, 1);
  return quoted + '"';
}

// Avoids "-0" in the output.
double WithoutMinusZero(double value) { return value == 0 ? 0 : value; }

absl::StatusOr<MimicIndex> IndexMimics(const Skeleton& skeleton,
                                       std::span<const MimicJoint> mimics) {
  std::unordered_map<std::string_view, const Joint*> joints;
  for (const Joint& joint : skeleton.joints()) joints.emplace(joint.name, &joint);
  MimicIndex index;
  for (const MimicJoint& mimic : mimics) {
    const auto joint = joints.find(mimic.joint);
    const auto master = joints.find(mimic.master);
    if (joint == joints.end() || !joint->second->dofs.empty() || master == joints.end() ||
        master->second->dofs.size() != 1) {
      return InvalidArgument(
          "joint table: expected mimic joint '{}' with 0 degrees of freedom and its master '{}' "
          "with 1",
          mimic.joint, mimic.master);
    }
    if (!std::isfinite(mimic.multiplier) || !std::isfinite(mimic.offset)) {
      return InvalidArgument("joint table: mimic joint '{}' has a number that is not finite",
                             mimic.joint);
    }
    index.emplace(mimic.joint, &mimic);
  }
  return index;
}

absl::StatusOr<std::vector<Column>> Columns(const Skeleton& skeleton,
                                            std::span<const MimicJoint> mimics) {
  MOTIONDB_ASSIGN_OR_RETURN(const MimicIndex mimic_of, IndexMimics(skeleton, mimics));
  std::vector<Column> columns;
  for (int j = 1; j < skeleton.joint_count(); ++j) {
    const Joint& joint = skeleton.joints()[j];
    if (joint.parent < 0) {
      return InvalidArgument("joint table: expected one root, found '{}' and '{}'",
                             skeleton.joints()[0].name, joint.name);
    }
    const int dof = skeleton.first_dof(j);
    if (const auto mimic = mimic_of.find(joint.name); mimic != mimic_of.end()) {
      const int master = skeleton.FindJoint(mimic->second->master);
      columns.push_back({joint.name, skeleton.first_dof(master), mimic->second->multiplier,
                         mimic->second->offset});
    } else if (joint.dofs.size() == 1) {
      columns.push_back({joint.name, dof});
    } else {
      for (int k = 0; k < static_cast<int>(joint.dofs.size()); ++k) {
        columns.push_back({fmt::format("{}/{}", joint.name, k + 1), dof + k});
      }
    }
  }
  std::unordered_set<std::string_view> names(std::begin(kPoseColumns), std::end(kPoseColumns));
  for (const Column& column : columns) {
    if (!names.insert(column.name).second) {
      return InvalidArgument("joint table: two columns would be named '{}'", column.name);
    }
  }
  return columns;
}

std::string WriteTable(const JointMotion& motion, const std::vector<Column>& columns) {
  const Skeleton& skeleton = *motion.skeleton;
  std::string text;
  for (const std::string_view name : kPoseColumns) {
    text += name;
    text += ',';
  }
  for (const Column& column : columns) text += Field(column.name) + ',';
  text.back() = '\n';

  const Joint& root = skeleton.joints()[0];
  Eigen::Quaterniond previous = Eigen::Quaterniond::Identity();
  for (Eigen::Index frame = 0; frame < motion.angles.rows(); ++frame) {
    const std::size_t begin = text.size();
    const double* row = motion.angles.data() + frame * motion.angles.cols();
    const Eigen::Isometry3d pose = ParentFromJoint(root, {row, root.dofs.size()});
    Eigen::Quaterniond turn = Eigen::Quaterniond(pose.linear()).normalized();
    if (turn.dot(previous) < 0) turn.coeffs() = -turn.coeffs();
    previous = turn;
    const auto put = [&](double value) {
      fmt::format_to(std::back_inserter(text), "{},", WithoutMinusZero(value));
    };
    put(static_cast<double>(frame) / motion.frame_rate_hz);
    for (const double value : pose.translation()) put(value);
    for (const double value : turn.coeffs()) put(value);
    for (const Column& column : columns) put(column.factor * row[column.dof] + column.offset);
    text.back() = '\n';
    if (frame == 0) ReserveFrames(text, text.size() - begin, motion.angles.rows() - 1);
  }
  return text;
}

}  // namespace

absl::StatusOr<std::string> WriteJointTable(const JointMotion& motion,
                                            std::span<const MimicJoint> mimics) {
  MOTIONDB_RETURN_IF_ERROR(CheckWritable("joint table", motion));
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<Column> columns, Columns(*motion.skeleton, mimics));
  return WriteTable(motion, columns);
}

}  // namespace motiondb::core
