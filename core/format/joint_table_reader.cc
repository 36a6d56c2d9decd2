#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <string_view>
#include <utility>
#include <vector>

#include "core/format/conventions.h"
#include "core/format/gunzip.h"
#include "core/format/joint_table.h"
#include "core/format/readers.h"
#include "core/format/text_scanner.h"
#include "core/format/urdf_reader.h"
#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"

namespace motiondb::core {
namespace {

constexpr double kCentimetre_m = 0.01;
constexpr double kBonesSeedRate_hz = 120;
constexpr double kPlainRate_hz = 30;
constexpr int kQuaternionColumns = 4;

// Converts the rows of a table of joints to motion.
class JointTable {
 public:
  JointTable(SourceFile file, const ReadOptions& options, UrdfRobot robot)
      : file_(file), options_(options), robot_(std::move(robot)) {
    report_.notes = std::move(robot_.report.notes);
  }

  absl::StatusOr<MotionFile> Read(CsvRows rows, std::span<const std::string> header,
                                  SourceFile urdf) {
    const bool plain = header.empty();
    first_row_ = plain ? 0 : 1;
    const auto width = static_cast<int>(rows.cells().size());
    MOTIONDB_ASSIGN_OR_RETURN(columns_, plain ? ColumnsWithoutHeader(rows, width, urdf, robot_)
                                              : ColumnsOfHeader(rows, header, robot_));
    MOTIONDB_ASSIGN_OR_RETURN(values_,
                              ReadNumberRows(rows, columns_.names, EmptyCells::kError, plain));
    Note(std::move(columns_.notes));
    MOTIONDB_ASSIGN_OR_RETURN(const double rate_hz, FrameRate());
    MOTIONDB_RETURN_IF_ERROR(CheckFrameNumbers());
    angles_ = JointMatrix::Zero(values_.rows(), robot_.skeleton.dof_count());
    DecideUpAxis(
        {.given = options_.up_axis,
         .stated = columns_.layout == TableLayout::kMotiondb ? std::optional<UpAxis>(UpAxis::kZ)
                                                             : std::nullopt,
         .deduced = {},
         .fallback = UpAxis::kZ},
        report_);
    ConvertJoints();
    MOTIONDB_RETURN_IF_ERROR(ConvertRotations());
    ConvertPositions();
    NoteMimics();
    NoteLimits();
    if (auto note = NoteOnFileEnd(TextScanner(file_))) report_.notes.push_back(*std::move(note));
    MotionFile read;
    read.report = std::move(report_);
    read.motion =
        JointMotion{.skeleton = std::make_shared<const Skeleton>(std::move(robot_.skeleton)),
                    .frame_rate_hz = rate_hz,
                    .angles = std::move(angles_)};
    return read;
  }

 private:
  void Note(std::vector<std::string> notes) {
    for (std::string& note : notes) report_.notes.push_back(std::move(note));
  }

  template <typename... Args>
  absl::Status ErrorAt(Eigen::Index frame, fmt::format_string<Args...> format,
                       Args&&... args) const {
    return InvalidArgument("{}:{}: {}", file_.name, LineOfRow(file_, first_row_ + frame),
                           fmt::format(format, std::forward<Args>(args)...));
  }

  absl::Status CheckFrameNumbers() const {
    if (!columns_.frame) return absl::OkStatus();
    for (Eigen::Index frame = 1; frame < values_.rows(); ++frame) {
      const double expected = values_(frame - 1, *columns_.frame) + 1;
      if (const double found = values_(frame, *columns_.frame); found != expected) {
        return ErrorAt(frame, "expected frame {}, found {}", expected, found);
      }
    }
    return absl::OkStatus();
  }

  absl::StatusOr<double> FrameRate() {
    if (options_.frame_rate_hz) return *options_.frame_rate_hz;
    if (columns_.time && values_.rows() > 1) {
      return FrameRateOfTimes(file_, values_.col(*columns_.time), first_row_, report_.notes);
    }
    if (!columns_.time && columns_.layout == TableLayout::kMotiondb) {
      return ErrorAt(-1, "expected a column time_s, or a frame rate (--frame-rate)");
    }
    const double usual =
        columns_.layout == TableLayout::kBonesSeed ? kBonesSeedRate_hz : kPlainRate_hz;
    report_.notes.push_back(fmt::format("frame rate {} Hz (assumed)", usual));
    return usual;
  }

  double RadiansPer(AngleUnit unit) const {
    return unit == AngleUnit::kDegrees ? kRadiansPerDegree : 1;
  }

  // Converts a value of a column to rad, or returns that of a slide (m).
  double ValueOf(const JointColumn& joint, Eigen::Index frame) const {
    const double value = values_(frame, joint.column);
    return is_hinge_[joint.dof] ? value * RadiansPer(joint.unit.value_or(angle_unit_)) : value;
  }

  void DecideAngleUnit() {
    const auto is_stated = [](const JointColumn& joint) { return joint.unit.has_value(); };
    const bool defined = columns_.layout == TableLayout::kMotiondb;
    const AngleUnit usual =
        columns_.layout == TableLayout::kBonesSeed ? AngleUnit::kDegrees : AngleUnit::kRadians;
    std::optional<AngleUnit> deduced = DeduceAngleUnit(
        values_, columns_, robot_.skeleton, defined ? kStrictExcess_rad : kUsualExcess_rad);
    if (deduced == AngleUnit::kRadians && TurnsFarInRadians()) deduced.reset();
    angle_unit_ = deduced.value_or(usual);
    Provenance provenance = deduced ? Provenance::kDeduced : Provenance::kAssumed;
    if (defined && angle_unit_ == usual) provenance = Provenance::kStated;
    std::string_view name = angle_unit_ == AngleUnit::kDegrees ? "degrees" : "radians";
    if (std::any_of(columns_.joints.begin(), columns_.joints.end(), is_stated)) {
      name = "the units of the header";
      provenance = Provenance::kStated;
    }
    report_.notes.push_back(fmt::format("joint angles in {} ({})", name, NameOf(provenance)));
  }

  // Whether the root's angles are too large to be radians.
  bool TurnsFarInRadians() const {
    constexpr double kFar = 2 * std::numbers::pi;
    if (columns_.rotation.size() == kQuaternionColumns) return false;
    return std::any_of(columns_.rotation.begin(), columns_.rotation.end(), [&](int column) {
      return (values_.col(column).array().abs() > kFar).any();
    });
  }

  void ConvertJoints() {
    for (const Joint& joint : robot_.skeleton.joints()) {
      for (const Dof& dof : joint.dofs) is_hinge_.push_back(dof.kind == Dof::Kind::kRotation);
    }
    DecideAngleUnit();
    for (const JointColumn& joint : columns_.joints) {
      if (joint.mimic != nullptr) continue;
      for (Eigen::Index frame = 0; frame < values_.rows(); ++frame) {
        angles_(frame, joint.dof) = ValueOf(joint, frame);
      }
    }
  }

  // Moves the scalar of the quaternions to the end, if it is first.
  void OrderQuaternions() {
    if (columns_.layout != TableLayout::kPlain) return;
    std::vector<int>& at = columns_.rotation;
    if (!IsScalarFirst(values_.middleCols(at[0], kQuaternionColumns), report_.up_axis)) return;
    std::rotate(at.begin(), at.begin() + 1, at.end());
    report_.notes.push_back("quaternions in the order w x y z (deduced: the robot is upright)");
  }

  absl::StatusOr<Eigen::Matrix3d> RotationOf(Eigen::Index frame) {
    const std::vector<int>& at = columns_.rotation;
    const auto row = values_.row(frame);
    if (at.size() < kQuaternionColumns) {
      const Eigen::Vector3d rpy =
          RadiansPer(angle_unit_) * Eigen::Vector3d(row[at[0]], row[at[1]], row[at[2]]);
      return (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
              Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
              Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
    }
    constexpr double kMinNorm = 0.5;
    constexpr double kMaxNorm = 2;
    const Eigen::Quaterniond turn(row[at[3]], row[at[0]], row[at[1]], row[at[2]]);
    const double norm = turn.norm();
    if (!(norm >= kMinNorm && norm <= kMaxNorm)) {
      return ErrorAt(frame, "expected a quaternion of the root with norm 1, found norm {:.4g}",
                     norm);
    }
    norm_error_ = std::max(norm_error_, std::abs(norm - 1));
    return turn.normalized().toRotationMatrix();
  }

  absl::Status ConvertRotations() {
    constexpr double kNotedNorm = 0.01;
    if (columns_.rotation.size() == kQuaternionColumns) OrderQuaternions();
    const Joint& base = robot_.skeleton.joints()[0];
    const std::array<Eigen::Vector3d, 3> axes = {base.dofs[3].axis, base.dofs[4].axis,
                                                 base.dofs[5].axis};
    const Eigen::Matrix3d world_from_file = WorldFromFile(report_.up_axis);
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();
    for (Eigen::Index frame = 0; frame < values_.rows(); ++frame) {
      MOTIONDB_ASSIGN_OR_RETURN(const Eigen::Matrix3d rotation, RotationOf(frame));
      turn = AnglesAboutAxes(base.pre_rotation.transpose() * world_from_file * rotation *
                                 base.post_rotation.transpose(),
                             axes, turn);
      angles_.block<1, 3>(frame, 3) = turn.transpose();
    }
    if (norm_error_ > kNotedNorm) {
      report_.notes.push_back(fmt::format(
          "quaternions were normalized, their norms differ from 1 by up to {:.2g}", norm_error_));
    }
    return absl::OkStatus();
  }

  void ConvertPositions() {
    const Eigen::Matrix3d world_from_file = WorldFromFile(report_.up_axis);
    JointMatrix root(values_.rows(), 3);
    for (int axis = 0; axis < 3; ++axis) {
      root.col(axis) = values_.col(columns_.position[axis]);
    }
    root *= world_from_file.transpose();
    const bool seed = columns_.layout == TableLayout::kBonesSeed;
    const bool known = options_.metres_per_unit || columns_.metres_per_unit;
    DecideUnit({.given = options_.metres_per_unit,
                .stated = columns_.metres_per_unit,
                .deduced = known ? std::nullopt : DeduceRootUnit(root, angles_, robot_.skeleton),
                .fallback = seed ? kCentimetre_m : 1},
               report_);
    const Joint& base = robot_.skeleton.joints()[0];
    Eigen::Matrix3d axes;
    axes << base.dofs[0].axis, base.dofs[1].axis, base.dofs[2].axis;
    angles_.leftCols<3>() = (report_.metres_per_unit * root).rowwise() - base.offset_m.transpose();
    angles_.leftCols<3>() *= axes;
  }

  void NoteMimics() {
    constexpr double kSame = 1e-3;  // rad or m
    double worst = kSame;
    std::string_view name;
    for (const JointColumn& joint : columns_.joints) {
      if (joint.mimic == nullptr) continue;
      const MimicJoint& mimic = *joint.mimic;
      for (Eigen::Index frame = 0; frame < values_.rows(); ++frame) {
        const double expected = mimic.multiplier * angles_(frame, joint.dof) + mimic.offset;
        const double difference = std::abs(ValueOf(joint, frame) - expected);
        if (difference <= worst) continue;
        worst = difference;
        name = mimic.joint;
      }
    }
    if (name.empty()) return;
    report_.notes.push_back(fmt::format(
        "mimic joint '{}' differs from its master's value by up to {:.2g} (rad or m): ignored",
        Shown(name), worst));
  }

  void NoteLimits() {
    constexpr double kTolerance = 1e-3;  // rad or m; tables are rounded
    std::int64_t values = 0;
    int joints = 0;
    double worst = kTolerance;
    std::string_view name;
    const Skeleton& skeleton = robot_.skeleton;
    for (int j = 1; j < skeleton.joint_count(); ++j) {
      const Joint& joint = skeleton.joints()[j];
      std::int64_t outside = 0;
      for (std::size_t k = 0; k < joint.dofs.size(); ++k) {
        const Dof& dof = joint.dofs[k];
        const auto column = skeleton.first_dof(j) + static_cast<Eigen::Index>(k);
        for (Eigen::Index frame = 0; frame < angles_.rows(); ++frame) {
          const double value = angles_(frame, column);
          const double excess = std::max(dof.lower - value, value - dof.upper);
          outside += excess > kTolerance ? 1 : 0;
          if (excess <= worst) continue;
          worst = excess;
          name = joint.name;
        }
      }
      values += outside;
      joints += outside > 0 ? 1 : 0;
    }
    if (values == 0) return;
    report_.notes.push_back(fmt::format(
        "{} values of {} joints are outside of their limits, the farthest by {:.2g} ('{}')", values,
        joints, worst, Shown(name)));
  }

  SourceFile file_;
  const ReadOptions& options_;
  UrdfRobot robot_;
  SourceReport report_;
  JointTableColumns columns_;
  std::int64_t first_row_ = 0;  // of the numbers, in the file
  JointMatrix values_;          // as in the file
  AngleUnit angle_unit_ = AngleUnit::kRadians;
  std::vector<bool> is_hinge_;  // of each degree of freedom
  double norm_error_ = 0;       // of the quaternions
  JointMatrix angles_;
};

}  // namespace

absl::StatusOr<MotionFile> ReadJointTable(SourceFile file, std::optional<SourceFile> urdf,
                                          const ReadOptions& options) {
  CsvRows rows(file);
  MOTIONDB_ASSIGN_OR_RETURN(const bool any, rows.Next());
  if (!any) return rows.Error("the file is empty, expected a table of joints or points");
  if (rows.cells().size() > 1 && rows.cells().back().empty()) rows.DropLastCell();
  std::vector<std::string> header;
  if (!ParseNumber(rows.cells().front())) {
    for (const std::string_view cell : rows.cells()) header.push_back(ToUtf8(cell));
    if (!IsJointTableHeader(header)) {
      if (header[0] == "time_s") return ReadPointTable(file, std::move(rows), header, options);
      return rows.Error(
          "expected a table of joints (time_s, root_x_m ... or Frame, root_translateX ...) or of "
          "points (time_s, NAME_x_m ...), or numbers without a header, found '{}'",
          Shown(header[0]));
    }
  }
  if (!urdf) return rows.Error("expected the robot's URDF (--skeleton FILE.urdf)");
  MOTIONDB_ASSIGN_OR_RETURN(UrdfRobot robot, ReadUrdf(*urdf));
  return JointTable(file, options, std::move(robot)).Read(std::move(rows), header, *urdf);
}

std::int64_t MaxBytesToReadJointTable(SourceFile file, std::optional<SourceFile> urdf) {
  constexpr std::int64_t kCell = 24;     // as read, the result, and one list of times
  constexpr std::int64_t kName = 800;    // including the sets that make names unique
  constexpr std::int64_t kJoint = 4096;  // including the temporary skeletons
  constexpr std::int64_t kMinJointText = 40;
  constexpr std::int64_t kDocument = 31;  // of the URDF's bytes, see urdf_file.cc
  std::int64_t bytes = kCell * MaxCsvSize(file.bytes).cells;
  const CsvRows rows(file);
  const std::string_view first = rows.rest();
  bytes +=
      kName * std::min<std::int64_t>(
                  kMaxTableColumns, MaxCsvSize(first.substr(0, first.find_first_of("\r\n"))).cells);
  if (!urdf) return bytes;
  const auto text = static_cast<std::int64_t>(PlainBytes(urdf->bytes, kMaxSkeletonBytes));
  return bytes + kDocument * text +
         kJoint * std::min<std::int64_t>(kMaxFileJoints, text / kMinJointText);
}

}  // namespace motiondb::core
