#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/export/writers.h"
#include "core/format/conventions.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"
#include "import/npz/npz_reader.h"
#include "import/npz/sampled_motion.h"

namespace motiondb::importer {
namespace {

Eigen::Vector3d NpzVector(const NpzTable& table, std::size_t row, std::size_t column) {
  return {table.at(row, column), table.at(row, column + 1), table.at(row, column + 2)};
}

Eigen::Quaterniond NpzQuaternion(const NpzTable& table, std::size_t row, std::size_t column) {
  Eigen::Quaterniond rotation;
  rotation.coeffs() << table.at(row, column), table.at(row, column + 1), table.at(row, column + 2),
      table.at(row, column + 3);
  return rotation;
}

absl::Status CheckNpzQuaternions(std::string_view file_name, const NpzTable& table) {
  constexpr double kMaxDeviation = 1e-3;  // of the norm, for numbers rounded to half precision
  for (std::size_t row = 0; row < table.rows(); ++row) {
    for (std::size_t column = 0; column < table.columns(); column += 4) {
      const double norm = NpzQuaternion(table, row, column).norm();
      if (std::abs(norm - 1) <= kMaxDeviation) continue;
      return core::InvalidArgument(
          "{}: array '{}': row {}, column {}: expected a quaternion of norm 1, found {}", file_name,
          table.name(), row, column, norm);
    }
  }
  return absl::OkStatus();
}

absl::Status RequireArrays(const NpzSource& source, std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names) {
    if (source.archive.Has(name)) continue;
    return core::InvalidArgument("{}: expected the array '{}' of motiondb; found {}",
                                 source.file_name, name, ArrayList(source.archive));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::string>> ReadPointNames(const NpzSource& source,
                                                        std::string_view array,
                                                        std::vector<std::string>& notes) {
  MOTIONDB_ASSIGN_OR_RETURN(std::vector<std::string> names,
                            ReadTexts(source.archive, source.file_name, array));
  core::UniqueNames unique;
  for (std::string& name : names) {
    if (name.empty()) {
      return core::InvalidArgument("{}: array '{}': name {} is empty", source.file_name, array,
                                   &name - names.data());
    }
    name = unique.Add(name);
  }
  if (std::string note = unique.Note(); !note.empty()) notes.push_back(std::move(note));
  return names;
}

absl::StatusOr<std::vector<int>> ReadNpzParents(const NpzSource& source, std::size_t joints) {
  MOTIONDB_ASSIGN_OR_RETURN(const NpyArray array, source.archive.Read("parents"));
  if (array.is_text() || array.shape().size() != 1 || array.size() != joints) {
    return core::InvalidArgument("{}: array 'parents': expected {} numbers, found the shape {}",
                                 source.file_name, joints, ShapeText(array.shape()));
  }
  std::vector<int> parents;
  for (std::size_t j = 0; j < joints; ++j) {
    const double parent = array.Number(j);
    if (!(parent >= -1 && parent < static_cast<double>(j) && parent == std::floor(parent))) {
      return core::InvalidArgument(
          "{}: array 'parents': joint {}: expected -1 or a joint before it, found {}",
          source.file_name, j, parent);
    }
    parents.push_back(static_cast<int>(parent));
  }
  return parents;
}

// The frames of joints in the file, and their conversion to the world.
struct JointTables {
  NpzTable rotations;
  NpzTable positions;
  double metres_per_unit;
  Eigen::Matrix3d world_from_file;

  Eigen::Isometry3d Pose(std::size_t joint, bool is_root, std::size_t frame) const {
    Eigen::Isometry3d pose;
    pose.linear() = NpzQuaternion(rotations, frame, 4 * joint).normalized().toRotationMatrix();
    pose.translation() = metres_per_unit * NpzVector(positions, frame, 3 * joint);
    pose.makeAffine();
    return is_root ? Eigen::Isometry3d(world_from_file) * pose : pose;
  }
};

absl::StatusOr<core::JointMotion> ReadNpzJoints(const NpzSource& source, core::SourceReport& report,
                                                double rate_hz) {
  MOTIONDB_RETURN_IF_ERROR(
      RequireArrays(source, {"parents", "offsets_m", "local_rotations", "local_positions_m"}));
  MOTIONDB_ASSIGN_OR_RETURN(std::vector<std::string> names,
                            ReadPointNames(source, "joint_names", report.notes));
  const std::size_t count = names.size();
  if (count == 0 || count > core::kMaxFileJoints) {
    return core::InvalidArgument("{}: array 'joint_names': expected 1 to {} joints, found {}",
                                 source.file_name, core::kMaxFileJoints, count);
  }
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<int> parents, ReadNpzParents(source, count));
  MOTIONDB_ASSIGN_OR_RETURN(const NpzTable offsets,
                            ReadTable(source.archive, source.file_name, "offsets_m", {3}));
  MOTIONDB_ASSIGN_OR_RETURN(NpzTable rotations, ReadTable(source.archive, source.file_name,
                                                          "local_rotations", {4 * count}));
  MOTIONDB_ASSIGN_OR_RETURN(NpzTable positions, ReadTable(source.archive, source.file_name,
                                                          "local_positions_m", {3 * count}));
  std::optional<NpzTable> rest;
  if (source.archive.Has("rest_rotations")) {
    MOTIONDB_ASSIGN_OR_RETURN(rest,
                              ReadTable(source.archive, source.file_name, "rest_rotations", {4}));
    MOTIONDB_RETURN_IF_ERROR(CheckNpzQuaternions(source.file_name, *rest));
  }
  if (offsets.rows() != count || (rest && rest->rows() != count)) {
    return core::InvalidArgument("{}: expected {} rows in 'offsets_m' and 'rest_rotations'",
                                 source.file_name, count);
  }
  MOTIONDB_RETURN_IF_ERROR(CheckSameRows(source.file_name, positions, rotations));
  MOTIONDB_RETURN_IF_ERROR(CheckNpzQuaternions(source.file_name, rotations));
  const std::size_t frames = rotations.rows();
  // Six degrees of freedom of a joint at most.
  MOTIONDB_RETURN_IF_ERROR(CheckMotionSize(source, frames, 6 * count * sizeof(double)));

  const JointTables tables{.rotations = std::move(rotations),
                           .positions = std::move(positions),
                           .metres_per_unit = report.metres_per_unit,
                           .world_from_file = core::WorldFromFile(report.up_axis)};
  std::vector<SampledJoint> joints;
  for (std::size_t j = 0; j < count; ++j) {
    SampledJoint joint{.name = std::move(names[j]),
                       .parent = parents[j],
                       .offset_m = report.metres_per_unit * NpzVector(offsets, j, 0)};
    if (rest) joint.rest_rotation = NpzQuaternion(*rest, j, 0).normalized().toRotationMatrix();
    if (joint.parent < 0) {
      joint.offset_m = tables.world_from_file * joint.offset_m;
      joint.rest_rotation = tables.world_from_file * joint.rest_rotation;
    }
    joints.push_back(std::move(joint));
  }
  return MotionOfSamples(joints.front().name, joints, static_cast<Eigen::Index>(frames), rate_hz,
                         [&](int joint, Eigen::Index frame) {
                           return tables.Pose(static_cast<std::size_t>(joint), parents[joint] < 0,
                                              static_cast<std::size_t>(frame));
                         });
}

absl::StatusOr<core::MarkerMotion> ReadNpzMarkers(const NpzSource& source,
                                                  core::SourceReport& report, double rate_hz) {
  MOTIONDB_RETURN_IF_ERROR(RequireArrays(source, {"positions_m"}));
  MOTIONDB_ASSIGN_OR_RETURN(std::vector<std::string> names,
                            ReadPointNames(source, "marker_names", report.notes));
  MOTIONDB_ASSIGN_OR_RETURN(const NpzTable table,
                            ReadTable(source.archive, source.file_name, "positions_m",
                                      {3 * names.size()}, Gaps::kAllowed));
  MOTIONDB_RETURN_IF_ERROR(CheckMotionSize(source, table.rows(), table.columns() * sizeof(float)));
  core::MarkerMotion motion{.names = std::move(names), .frame_rate_hz = rate_hz, .positions_m = {}};
  motion.positions_m.resize(static_cast<Eigen::Index>(table.rows()),
                            static_cast<Eigen::Index>(table.columns()));
  for (std::size_t frame = 0; frame < table.rows(); ++frame) {
    for (std::size_t column = 0; column < table.columns(); column += 3) {
      const Eigen::Vector3d at = NpzVector(table, frame, column);
      if (!at.array().isFinite().all() && !at.array().isNaN().all()) {
        return core::InvalidArgument(
            "{}: array 'positions_m': frame {}, column {}: expected all three coordinates of "
            "marker '{}' or none",
            source.file_name, frame, column, motion.names[column / 3]);
      }
      motion.positions_m.block<1, 3>(static_cast<Eigen::Index>(frame),
                                     static_cast<Eigen::Index>(column)) =
          at.transpose().cast<float>();
    }
  }
  core::ToWorld(report, motion.positions_m);
  return motion;
}

}  // namespace

absl::StatusOr<core::MotionFile> ReadMotiondbNpz(const NpzSource& source,
                                                 const core::ReadOptions& options) {
  MOTIONDB_ASSIGN_OR_RETURN(const double version,
                            ReadScalar(source.archive, source.file_name, "motiondb_version"));
  if (version != core::kNpzVersion) {
    return core::InvalidArgument("{}: array 'motiondb_version': expected {}, found {}",
                                 source.file_name, core::kNpzVersion, version);
  }
  MOTIONDB_RETURN_IF_ERROR(RequireArrays(source, {"frame_rate_hz"}));
  MOTIONDB_ASSIGN_OR_RETURN(const double stated,
                            ReadScalar(source.archive, source.file_name, "frame_rate_hz"));
  const double rate_hz = options.frame_rate_hz.value_or(stated);
  if (!core::IsFrameRate(rate_hz)) {
    return core::InvalidArgument(
        "{}: array 'frame_rate_hz': expected a frame rate from 0.001 to 100000 Hz, found {}",
        source.file_name, rate_hz);
  }
  core::MotionFile read;
  core::DecideUnit({.given = options.metres_per_unit, .stated = 1, .deduced = {}, .fallback = 1},
                   read.report);
  core::DecideUpAxis({.given = options.up_axis,
                      .stated = core::UpAxis::kZ,
                      .deduced = {},
                      .fallback = core::UpAxis::kZ},
                     read.report);
  if (source.archive.Has("marker_names")) {
    MOTIONDB_ASSIGN_OR_RETURN(read.motion, ReadNpzMarkers(source, read.report, rate_hz));
    return read;
  }
  MOTIONDB_RETURN_IF_ERROR(RequireArrays(source, {"joint_names"}));
  MOTIONDB_ASSIGN_OR_RETURN(read.motion, ReadNpzJoints(source, read.report, rate_hz));
  return read;
}

}  // namespace motiondb::importer
