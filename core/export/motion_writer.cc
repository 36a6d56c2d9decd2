#include "core/export/motion_writer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string_view>
#include <utility>
#include <variant>

#include "core/export/writers.h"
#include "core/format/motion_file.h"
#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"
#include "core/motion/states.h"

namespace motiondb::core {
namespace {

// Returns the markers that have a position, without gaps. INVALID_ARGUMENT if there is none.
absl::StatusOr<MarkerMotion> WithoutGaps(const MarkerMotion& markers, WrittenMotion& written) {
  MarkerMotion filled;
  filled.frame_rate_hz = markers.frame_rate_hz;
  filled.positions_m.resize(markers.positions_m.rows(), markers.positions_m.cols());
  Eigen::Index next = 0;
  Eigen::Index gaps = 0;
  std::string missing;
  for (std::size_t i = 0; i < markers.names.size(); ++i) {
    const auto positions = markers.positions_m.middleCols<3>(static_cast<Eigen::Index>(3 * i));
    const Eigen::Index gap = positions.col(0).array().isNaN().count();
    if (gap == positions.rows()) {
      missing += (missing.empty() ? "" : ", ") + markers.names[i];
      continue;
    }
    gaps += gap;
    filled.names.push_back(markers.names[i]);
    filled.positions_m.middleCols<3>(next) = positions;
    next += 3;
  }
  if (filled.names.empty()) return InvalidArgument("no marker has a position in any frame");
  filled.positions_m.conservativeResize(Eigen::NoChange, next);
  if (!missing.empty()) written.losses.push_back("markers without a position: " + missing);
  if (gaps > 0) written.losses.push_back(fmt::format("gaps: {} positions are filled", gaps));
  MOTIONDB_RETURN_IF_ERROR(FillGaps(std::numeric_limits<double>::infinity(), filled).status());
  return filled;
}

// Returns a skeleton with a joint that only moves for each marker, under one root at the origin.
absl::StatusOr<JointMotion> MarkersAsJoints(const MarkerMotion& markers, WrittenMotion& written) {
  MOTIONDB_ASSIGN_OR_RETURN(const MarkerMotion filled, WithoutGaps(markers, written));
  constexpr Eigen::Index kRootDofs = 3;  // some readers expect motion of the root
  Joint root{.name = "points"};
  for (int axis = 0; axis < 3; ++axis) {
    root.dofs.push_back({Dof::Kind::kTranslation, Eigen::Vector3d::Unit(axis)});
  }
  std::vector<Joint> joints = {root};
  for (const std::string& name : filled.names) {
    Joint joint = root;
    joint.name = name == root.name ? name + "_point" : name;
    joint.parent = 0;
    joints.push_back(std::move(joint));
  }
  MOTIONDB_ASSIGN_OR_RETURN(Skeleton skeleton, Skeleton::Create("points", std::move(joints)));
  JointMatrix angles(filled.positions_m.rows(), kRootDofs + filled.positions_m.cols());
  angles << JointMatrix::Zero(filled.positions_m.rows(), kRootDofs),
      filled.positions_m.cast<double>();
  return JointMotion{std::make_shared<const Skeleton>(std::move(skeleton)), markers.frame_rate_hz,
                     std::move(angles)};
}

absl::StatusOr<JointMotion> ToJoints(const Motion& motion, WrittenMotion& written) {
  if (const auto* const joints = std::get_if<JointMotion>(&motion)) return *joints;
  return MarkersAsJoints(std::get<MarkerMotion>(motion), written);
}

MarkerMotion ToMarkers(const Motion& motion, std::string_view format, WrittenMotion& written) {
  if (const auto* const markers = std::get_if<MarkerMotion>(&motion)) return *markers;
  written.losses.push_back(
      fmt::format("hierarchy and joint rotations: {} has points only", format));
  return JointsAsMarkers(std::get<JointMotion>(motion));
}

bool HasLimits(const Motion& motion) {
  const auto* const joints = std::get_if<JointMotion>(&motion);
  if (joints == nullptr) return false;
  for (const Joint& joint : joints->skeleton->joints()) {
    for (const Dof& dof : joint.dofs) {
      if (std::isfinite(dof.lower) || std::isfinite(dof.upper)) return true;
    }
  }
  return false;
}

absl::StatusOr<std::string> BytesOf(FileFormat format, const Motion& motion, const Mimics& mimics,
                                    WrittenMotion& written) {
  switch (format) {
    case FileFormat::kBvh: {
      MOTIONDB_ASSIGN_OR_RETURN(const JointMotion joints, ToJoints(motion, written));
      if (HasLimits(motion)) written.losses.emplace_back("joint limits: BVH has none");
      return WriteBvh(joints);
    }
    case FileFormat::kGltf: {
      MOTIONDB_ASSIGN_OR_RETURN(const JointMotion joints, ToJoints(motion, written));
      if (HasLimits(motion)) written.losses.emplace_back("joint limits: glTF has none");
      return WriteGlb(joints);
    }
    case FileFormat::kTrc:
      return WriteTrc(ToMarkers(motion, "TRC", written));
    case FileFormat::kC3d:
      return WriteC3d(ToMarkers(motion, "C3D", written));
    case FileFormat::kCsv:
      if (const auto* const joints = std::get_if<JointMotion>(&motion); joints && mimics) {
        return WriteJointTable(*joints, *mimics);
      }
      return WritePointTable(ToMarkers(motion, "a table of points", written));
    case FileFormat::kNpz:
      return WriteNpz(motion);
    default:
      return InvalidArgument("{} files are read only", InfoOf(format).name);
  }
}

}  // namespace

bool HasJoints(FileFormat format) {
  return format == FileFormat::kBvh || format == FileFormat::kGltf || format == FileFormat::kNpz;
}

bool IsRobot(const Skeleton& skeleton) {
  constexpr std::size_t kFloating = 6;
  const std::vector<Joint>& joints = skeleton.joints();
  if (joints[0].dofs.size() != kFloating || joints.size() == 1) return false;
  return std::all_of(joints.begin() + 1, joints.end(), [](const Joint& joint) {
    return joint.parent >= 0 && joint.dofs.size() <= 1;
  });
}

MarkerMotion JointsAsMarkers(const JointMotion& motion) {
  MarkerMotion markers;
  for (const Joint& joint : motion.skeleton->joints()) markers.names.push_back(joint.name);
  markers.frame_rate_hz = motion.frame_rate_hz;
  markers.positions_m = JointPositions(motion);
  return markers;
}

namespace {

// BVH states neither unit nor up axis, TRC no up axis: readers deduce them from the body. Reports
// what ours would deduce wrongly.
void CheckConventions(FileFormat format, WrittenMotion& written) {
  if (format != FileFormat::kBvh && format != FileFormat::kTrc) return;
  const auto back = ReadMotionFile(format, {"written", written.bytes});
  if (!back.ok()) return;  // one frame is not enough to read
  constexpr double kCentimetre = 0.01;
  const bool is_bvh = format == FileFormat::kBvh;
  if (is_bvh && std::abs(back->report.metres_per_unit - kCentimetre) > 1e-6) {
    written.losses.emplace_back("unit: BVH states none; read it with --metres-per-unit 0.01");
  }
  if (back->report.up_axis != UpAxis::kY) {
    written.losses.push_back(
        fmt::format("up axis: {} states none; read it with --up-axis y", is_bvh ? "BVH" : "TRC"));
  }
}

}  // namespace

absl::StatusOr<WrittenMotion> WriteMotion(FileFormat format, const Motion& motion,
                                          const Mimics& mimics) {
  MOTIONDB_RETURN_IF_ERROR(
      std::visit([&](const auto& one) { return CheckWritable(InfoOf(format).name, one); }, motion));
  WrittenMotion written;
  MOTIONDB_ASSIGN_OR_RETURN(written.bytes, BytesOf(format, motion, mimics, written));
  CheckConventions(format, written);
  return written;
}

}  // namespace motiondb::core
