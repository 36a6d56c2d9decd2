#include "core/export/motion_writer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "core/export/writers.h"
#include "core/format/motion_file.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"
#include "core/motion/marker_set.h"
#include "core/motion/states.h"

namespace motiondb::core {
namespace {

// Adds a note if names differ in the file: their number and the first of them. REQUIRES: equal
// sizes. O(names).
void ReportNames(const std::vector<std::string>& before, const std::vector<std::string>& after,
                 std::vector<std::string>& losses) {
  constexpr int kShownNames = 3;
  std::string examples;
  int changed = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (before[i] == after[i]) continue;
    if (++changed > kShownNames) continue;
    examples +=
        fmt::format("{}'{}' is '{}'", changed == 1 ? "" : ", ", Shown(before[i]), Shown(after[i]));
  }
  if (changed == 0) return;
  losses.push_back(fmt::format("names: {} of {} are changed: {}{}", changed, before.size(),
                               examples, changed > kShownNames ? ", ..." : ""));
}

// Adds notes if joints have limits, or axes that they turn about, in a format that keeps only their
// rotations. O(joints).
void ReportJointProperties(const Motion& motion, std::string_view format,
                           std::vector<std::string>& losses) {
  const auto* const joints = std::get_if<JointMotion>(&motion);
  if (joints == nullptr) return;
  bool has_limits = false;
  bool has_axes = false;
  for (const Joint& joint : joints->skeleton->joints()) {
    const auto rotations = std::count_if(joint.dofs.begin(), joint.dofs.end(), [](const Dof& dof) {
      return dof.kind == Dof::Kind::kRotation;
    });
    has_axes = has_axes || rotations == 1 || rotations == 2;
    for (const Dof& dof : joint.dofs) {
      has_limits = has_limits || std::isfinite(dof.lower) || std::isfinite(dof.upper);
    }
  }
  if (has_limits) losses.push_back(fmt::format("joint limits: {} has none", format));
  if (has_axes) {
    losses.push_back(fmt::format("joint axes: {} turns each joint about any axis", format));
  }
}

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
    if (joint.name != name) ReportNames({name}, {joint.name}, written.losses);
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

absl::StatusOr<std::string> BytesOf(FileFormat format, const Motion& motion, const Mimics& mimics,
                                    WrittenMotion& written) {
  switch (format) {
    case FileFormat::kBvh: {
      MOTIONDB_ASSIGN_OR_RETURN(const JointMotion joints, ToJoints(motion, written));
      ReportJointProperties(motion, "BVH", written.losses);
      ReportNames(JointNames(*joints.skeleton), BvhNames(*joints.skeleton), written.losses);
      return WriteBvh(joints);
    }
    case FileFormat::kGltf: {
      MOTIONDB_ASSIGN_OR_RETURN(const JointMotion joints, ToJoints(motion, written));
      ReportJointProperties(motion, "glTF", written.losses);
      ReportNames(JointNames(*joints.skeleton), GlbNames(*joints.skeleton), written.losses);
      return WriteGlb(joints);
    }
    case FileFormat::kTrc: {
      const MarkerMotion markers = ToMarkers(motion, "TRC", written);
      MOTIONDB_ASSIGN_OR_RETURN(const auto names, WritablePointNames("TRC", markers));
      ReportNames(markers.names, names, written.losses);
      return WriteTrc(markers);
    }
    case FileFormat::kC3d: {
      const MarkerMotion markers = ToMarkers(motion, "C3D", written);
      MOTIONDB_ASSIGN_OR_RETURN(const auto labels, C3dLabels(markers));
      ReportNames(markers.names, labels, written.losses);
      return WriteC3d(markers);
    }
    case FileFormat::kCsv: {
      if (const auto* const joints = std::get_if<JointMotion>(&motion); joints && mimics) {
        return WriteJointTable(*joints, *mimics);
      }
      const MarkerMotion markers = ToMarkers(motion, "a table of points", written);
      MOTIONDB_ASSIGN_OR_RETURN(const auto names, WritablePointNames("point table", markers));
      ReportNames(markers.names, names, written.losses);
      return WritePointTable(markers);
    }
    case FileFormat::kNpz:
      ReportJointProperties(motion, "NPZ", written.losses);
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
  markers.names = JointNames(*motion.skeleton);
  markers.frame_rate_hz = motion.frame_rate_hz;
  markers.positions_m = JointPositions(motion);
  return markers;
}

namespace {

// Returns frames spread over the motion, at most as many as the readers look at for conventions.
Motion SampledFrames(const Motion& motion) {
  const auto sample = [](const auto& all) {
    constexpr Eigen::Index kSamples = 32;
    const Eigen::Index count = std::min(kSamples, all.rows());
    std::remove_cvref_t<decltype(all)> some(count, all.cols());
    for (Eigen::Index i = 0; i < count; ++i) some.row(i) = all.row(i * all.rows() / count);
    return some;
  };
  if (const auto* const joints = std::get_if<JointMotion>(&motion)) {
    return JointMotion{joints->skeleton, joints->frame_rate_hz, sample(joints->angles)};
  }
  const auto& markers = std::get<MarkerMotion>(motion);
  return MarkerMotion{markers.names, markers.frame_rate_hz, sample(markers.positions_m)};
}

// BVH states neither unit nor up axis, TRC no up axis: readers deduce them from the body. Reports
// what ours would deduce wrongly.
void CheckConventions(FileFormat format, const Motion& motion, WrittenMotion& written) {
  if (format != FileFormat::kBvh && format != FileFormat::kTrc) return;
  WrittenMotion sampled;
  const Mimics none;
  const auto bytes = BytesOf(format, SampledFrames(motion), none, sampled);
  if (!bytes.ok()) return;  // all markers are missing in these frames
  const auto back = ReadMotionFile(format, {"written", *bytes});
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
  CheckConventions(format, motion, written);
  return written;
}

}  // namespace motiondb::core
