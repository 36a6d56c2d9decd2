#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/format/conventions.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"
#include "import/npz/npz_reader.h"
#include "import/npz/sampled_motion.h"
#include "import/npz/smpl_body.h"
#include "text/utf8.h"

namespace motiondb::importer {
namespace {

constexpr std::string_view kAistPoses = "smpl_poses";
constexpr std::string_view kAistTranslations = "smpl_trans";
constexpr std::string_view kAistScaling = "smpl_scaling";
constexpr double kAistRate_hz = 60;
constexpr double kSmplRate_hz = 30;  // of estimates from video, which seldom state it

constexpr std::array<std::string_view, 2> kAmassRates = {"mocap_framerate", "mocap_frame_rate"};
constexpr std::array<std::string_view, 3> kOtherRates = {"fps", "framerate", "frame_rate"};

// Where the file has the rotation of a joint.
struct RotationSource {
  int table = -1;  // -1: nowhere; the joint does not move
  std::size_t column = 0;
};

struct SmplPoses {
  SmplModel model = SmplModel::kSmpl;
  std::vector<NpzTable> tables;  // all with the same frames
  std::vector<RotationSource> joints;

  std::size_t frames() const { return tables.front().rows(); }
  // `table` has the rotations of consecutive joints from `first_joint` on.
  void Add(NpzTable table, std::size_t first_joint) {
    for (std::size_t k = 0; 3 * k < table.columns() && first_joint + k < joints.size(); ++k) {
      joints[first_joint + k] = {.table = static_cast<int>(tables.size()), .column = 3 * k};
    }
    tables.push_back(std::move(table));
  }
  Eigen::Matrix3d Rotation(int joint, std::size_t frame) const {
    const RotationSource& source = joints[joint];
    if (source.table < 0) return Eigen::Matrix3d::Identity();
    const NpzTable& table = tables[source.table];
    const Eigen::Vector3d turn(table.at(frame, source.column), table.at(frame, source.column + 1),
                               table.at(frame, source.column + 2));
    const double angle = turn.norm();
    if (angle == 0) return Eigen::Matrix3d::Identity();
    return Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
  }
};

// Returns the model of `surface_model_type`, such as "smplx_locked_head", if it is there.
std::optional<SmplModel> StatedModel(NpzArchive& archive) {
  const std::string type = text::LowerCase(TryText(archive, "surface_model_type").value_or(""));
  if (type.starts_with("smplx")) return SmplModel::kSmplX;
  if (type.starts_with("smplh")) return SmplModel::kSmplH;
  if (type.starts_with("smpl")) return SmplModel::kSmpl;
  return std::nullopt;
}

SmplPoses EmptyPoses(SmplModel model) {
  SmplPoses poses;
  poses.model = model;
  poses.joints.resize(SmplJoints(model).size());
  return poses;
}

absl::StatusOr<SmplPoses> ReadWholePoses(const NpzSource& source, std::string_view name,
                                         std::optional<SmplModel> stated) {
  constexpr std::size_t kBodyColumns = 66;
  constexpr std::size_t kSmplColumns = 72;
  constexpr std::size_t kSmplHColumns = 156;
  constexpr std::size_t kSmplXColumns = 165;
  MOTIONDB_ASSIGN_OR_RETURN(
      NpzTable table, name == kAistPoses
                          ? ReadTable(source.archive, source.file_name, name, {kSmplColumns})
                          : ReadTable(source.archive, source.file_name, name,
                                      {kBodyColumns, kSmplColumns, kSmplHColumns, kSmplXColumns}));
  SmplModel model = SmplModel::kSmpl;
  if (table.columns() == kBodyColumns) model = stated.value_or(SmplModel::kSmpl);
  if (table.columns() == kSmplHColumns) model = SmplModel::kSmplH;
  if (table.columns() == kSmplXColumns) model = SmplModel::kSmplX;
  SmplPoses poses = EmptyPoses(model);
  poses.Add(std::move(table), 0);
  return poses;
}

// Reads the rotations of an AMASS archive without `poses`.
absl::StatusOr<SmplPoses> ReadPosesInParts(const NpzSource& source,
                                           std::optional<SmplModel> stated) {
  struct Part {
    std::string_view name;
    std::size_t first_joint;
    std::size_t columns;
  };
  NpzArchive& archive = source.archive;
  SmplModel model = archive.Has("pose_hand") ? SmplModel::kSmplH : SmplModel::kSmpl;
  if (archive.Has("pose_jaw") || archive.Has("pose_eye")) model = SmplModel::kSmplX;
  model = stated.value_or(model);
  SmplPoses poses = EmptyPoses(model);
  std::vector<Part> parts = {{"root_orient", 0, 3}, {"pose_body", 1, 63}};
  if (model == SmplModel::kSmplX) {
    parts.insert(parts.end(), {{"pose_jaw", 22, 3}, {"pose_eye", 23, 6}, {"pose_hand", 25, 90}});
  } else if (model == SmplModel::kSmplH) {
    parts.push_back({"pose_hand", 22, 90});
  }
  for (const Part& part : parts) {
    if (!archive.Has(part.name)) continue;
    // SMPL's own body pose has 69 numbers: with the hands.
    const std::size_t other =
        part.first_joint == 1 && model == SmplModel::kSmpl ? 69 : part.columns;
    MOTIONDB_ASSIGN_OR_RETURN(
        NpzTable table, ReadTable(archive, source.file_name, part.name, {part.columns, other}));
    if (!poses.tables.empty()) {
      MOTIONDB_RETURN_IF_ERROR(CheckSameRows(source.file_name, table, poses.tables.front()));
    }
    poses.Add(std::move(table), part.first_joint);
  }
  return poses;
}

absl::StatusOr<SmplPoses> ReadSmplPoses(const NpzSource& source, std::vector<std::string>& notes) {
  const std::optional<SmplModel> stated = StatedModel(source.archive);
  if (source.archive.Has(kAistPoses)) return ReadWholePoses(source, kAistPoses, stated);
  if (!source.archive.Has("poses")) return ReadPosesInParts(source, stated);
  MOTIONDB_ASSIGN_OR_RETURN(SmplPoses poses, ReadWholePoses(source, "poses", stated));
  if (stated && *stated != poses.model) {
    notes.push_back(fmt::format("surface_model_type is {}, but the poses are those of {}",
                                NameOf(*stated), NameOf(poses.model)));
  }
  return poses;
}

// Returns translations in the unit of the file, and their divisor.
struct SmplTranslations {
  NpzTable table;
  double scaling = 1;
};

absl::StatusOr<SmplTranslations> ReadSmplTranslations(const NpzSource& source,
                                                      const NpzTable& poses) {
  const bool is_aist = poses.name() == kAistPoses;
  const std::string_view name = is_aist ? kAistTranslations : "trans";
  if (!source.archive.Has(name)) {
    return core::InvalidArgument("{}: expected the array '{}' beside '{}'; found {}",
                                 source.file_name, name, poses.name(), ArrayList(source.archive));
  }
  MOTIONDB_ASSIGN_OR_RETURN(NpzTable table, ReadTable(source.archive, source.file_name, name, {3}));
  MOTIONDB_RETURN_IF_ERROR(CheckSameRows(source.file_name, table, poses));
  SmplTranslations read{.table = std::move(table)};
  if (is_aist && source.archive.Has(kAistScaling)) {
    MOTIONDB_ASSIGN_OR_RETURN(read.scaling,
                              ReadScalar(source.archive, source.file_name, kAistScaling));
    if (!(read.scaling >= 1e-6 && read.scaling <= 1e6)) {
      return core::InvalidArgument("{}: array '{}': expected a scale from 1e-6 to 1e6, found {}",
                                   source.file_name, kAistScaling, read.scaling);
    }
  }
  return read;
}

template <std::size_t kCount>
std::optional<std::string_view> FirstArray(const NpzArchive& archive,
                                           const std::array<std::string_view, kCount>& names) {
  for (const std::string_view name : names) {
    if (archive.Has(name)) return name;
  }
  return std::nullopt;
}

absl::StatusOr<double> ReadSmplRate(const NpzSource& source, const SmplPoses& poses,
                                    const core::ReadOptions& options,
                                    std::vector<std::string>& notes) {
  if (options.frame_rate_hz) return *options.frame_rate_hz;
  std::optional<std::string_view> name = FirstArray(source.archive, kAmassRates);
  if (!name) name = FirstArray(source.archive, kOtherRates);
  if (name) {
    MOTIONDB_ASSIGN_OR_RETURN(const double rate_hz,
                              ReadScalar(source.archive, source.file_name, *name));
    if (core::IsFrameRate(rate_hz)) return core::SnapFrameRate(rate_hz, notes);
    return core::InvalidArgument(
        "{}: array '{}': expected a frame rate from 0.001 to 100000 Hz, found {}", source.file_name,
        *name, rate_hz);
  }
  if (poses.model != SmplModel::kSmpl) {
    return core::InvalidArgument(
        "{}: expected the frame rate in mocap_framerate, mocap_frame_rate or fps, or as an option "
        "(frame_rate_hz, --frame-rate); found {}",
        source.file_name, ArrayList(source.archive));
  }
  const bool is_aist = poses.tables.front().name() == kAistPoses;
  const double rate_hz = is_aist ? kAistRate_hz : kSmplRate_hz;
  notes.push_back(fmt::format("the file has no frame rate: {} Hz assumed{}", rate_hz,
                              is_aist ? ", as in AIST++" : ""));
  return rate_hz;
}

SmplGender ReadSmplGender(NpzArchive& archive, std::vector<std::string>& notes) {
  const std::string stated = TryText(archive, "gender").value_or("");
  std::string gender = text::LowerCase(stated);
  // Some archives have the Python text of a byte string: "b'male'".
  if (gender.starts_with("b'")) gender.erase(0, 2);
  if (gender.starts_with('m')) return SmplGender::kMale;
  if (gender.starts_with('f')) return SmplGender::kFemale;
  if (!gender.starts_with("neutral")) {
    notes.push_back(archive.Has("gender")
                        ? fmt::format("gender '{}' is not male, female or neutral: neutral assumed",
                                      core::Shown(stated))
                        : "the file states no gender: neutral assumed");
  }
  return SmplGender::kNeutral;
}

// The figure of a file: poses and translations on a mean body.
class SmplFigure {
 public:
  SmplFigure(SmplPoses poses, SmplTranslations translations, double stature_m)
      : poses_(std::move(poses)), translations_(std::move(translations)) {
    const std::vector<SmplJoint> joints = SmplJoints(poses_.model);
    for (const SmplJoint& joint : joints) {
      SampledJoint sampled{.name = std::string(joint.name), .parent = joint.parent};
      if (joint.parent >= 0)
        sampled.offset_m = stature_m * (joint.rest - joints[joint.parent].rest);
      joints_.push_back(std::move(sampled));
    }
  }

  std::size_t frames() const { return poses_.frames(); }
  int columns() const { return 3 * static_cast<int>(joints_.size()) + 3; }

  // Returns every step-th frame with the file's translations `metres_per_unit`. At zero angles the
  // body stands upright in axes whose y axis is `upright`'s.
  absl::StatusOr<core::JointMotion> Motion(double metres_per_unit,
                                           const Eigen::Matrix3d& world_from_file,
                                           const Eigen::Matrix3d& upright, double frame_rate_hz,
                                           std::size_t step = 1) const {
    std::vector<SampledJoint> joints = joints_;
    joints.front().rest_rotation = upright;
    const std::size_t count = (frames() + step - 1) / step;
    return MotionOfSamples(std::string(NameOf(poses_.model)), joints,
                           static_cast<Eigen::Index>(count), frame_rate_hz,
                           [&](int joint, Eigen::Index index) {
                             const std::size_t frame = static_cast<std::size_t>(index) * step;
                             Eigen::Isometry3d pose;
                             pose.linear() = poses_.Rotation(joint, frame);
                             pose.translation() = joint == 0 ? Pelvis(frame, metres_per_unit)
                                                             : joints_[joint].offset_m;
                             pose.makeAffine();
                             return joint == 0 ? Eigen::Isometry3d(world_from_file) * pose : pose;
                           });
  }

 private:
  Eigen::Vector3d Pelvis(std::size_t frame, double metres_per_unit) const {
    const NpzTable& table = translations_.table;
    const Eigen::Vector3d translation(table.at(frame, 0), table.at(frame, 1), table.at(frame, 2));
    return translation * (metres_per_unit / translations_.scaling) + SmplPelvis(poses_.model);
  }

  SmplPoses poses_;
  SmplTranslations translations_;
  std::vector<SampledJoint> joints_;
};

// Returns the axis along which the figure stands in frames spread over the clip.
absl::StatusOr<std::optional<core::UpAxis>> DeducedUpAxis(const SmplFigure& figure) {
  constexpr std::size_t kSamples = 32;
  const Eigen::Matrix3d same = Eigen::Matrix3d::Identity();
  MOTIONDB_ASSIGN_OR_RETURN(
      core::JointMotion sample,
      figure.Motion(1, same, same, 1, (figure.frames() + kSamples - 1) / kSamples));
  // Positions are floats, and files may be far from the origin.
  sample.angles.leftCols<3>().setZero();
  std::vector<std::string> names;
  for (const core::Joint& joint : sample.skeleton->joints()) names.push_back(joint.name);
  return core::DeduceConventions(names, core::JointPositions(sample), sample.skeleton.get())
      .up_axis;
}

}  // namespace

bool IsSmpl(const NpzArchive& archive) {
  return archive.Has("poses") || archive.Has(kAistPoses) ||
         (archive.Has("root_orient") && archive.Has("pose_body"));
}

absl::StatusOr<core::MotionFile> ReadSmpl(const NpzSource& source,
                                          const core::ReadOptions& options) {
  core::MotionFile read;
  core::SourceReport& report = read.report;
  MOTIONDB_ASSIGN_OR_RETURN(SmplPoses poses, ReadSmplPoses(source, report.notes));
  MOTIONDB_ASSIGN_OR_RETURN(SmplTranslations translations,
                            ReadSmplTranslations(source, poses.tables.front()));
  MOTIONDB_ASSIGN_OR_RETURN(const double rate_hz,
                            ReadSmplRate(source, poses, options, report.notes));
  const SmplGender gender = ReadSmplGender(source.archive, report.notes);
  const SmplModel model = poses.model;
  const auto still = std::count_if(poses.joints.begin(), poses.joints.end(),
                                   [](const RotationSource& joint) { return joint.table < 0; });
  const SmplFigure figure(std::move(poses), std::move(translations), SmplStature(gender));
  MOTIONDB_RETURN_IF_ERROR(CheckMotionSize(
      source, figure.frames(), static_cast<std::size_t>(figure.columns()) * sizeof(double)));

  report.notes.push_back(
      fmt::format("{} body derived from mean proportions ({}, stature {} m), not the subject's{}",
                  NameOf(model), NameOf(gender), SmplStature(gender),
                  source.archive.Has("betas") ? "; betas are ignored" : ""));
  if (still > 0) {
    report.notes.push_back(
        fmt::format("{} joints without rotations in the file do not move", still));
  }
  core::DecideUnit({.given = options.metres_per_unit, .stated = 1, .deduced = {}, .fallback = 1},
                   report);
  const bool is_amass = FirstArray(source.archive, kAmassRates).has_value();
  std::optional<core::UpAxis> deduced;
  if (!is_amass && !options.up_axis) {
    MOTIONDB_ASSIGN_OR_RETURN(deduced, DeducedUpAxis(figure));
  }
  core::DecideUpAxis({.given = options.up_axis,
                      .stated = is_amass ? std::optional(core::UpAxis::kZ) : std::nullopt,
                      .deduced = deduced,
                      .fallback = core::UpAxis::kY},
                     report);
  MOTIONDB_ASSIGN_OR_RETURN(
      read.motion, figure.Motion(report.metres_per_unit, core::WorldFromFile(report.up_axis),
                                 core::WorldFromFile(core::UpAxis::kY), rate_hz));
  return read;
}

}  // namespace motiondb::importer
