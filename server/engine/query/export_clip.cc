#include "server/engine/query/export_clip.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <memory>
#include <utility>

#include "core/export/motion_writer.h"
#include "core/format/urdf_reader.h"
#include "core/kinematics/inverse_kinematics.h"
#include "core/kinematics/marker_kinematics.h"
#include "core/mapping/fit_scheme.h"
#include "core/motion/error.h"
#include "core/motion/marker_set.h"
#include "core/motion/states.h"
#include "server/engine/engine.h"
#include "server/engine/ingest.h"
#include "server/engine/live_database.h"
#include "server/engine/source_reader.h"

namespace motiondb::server {
namespace {

// Skeletons of people have joints, such as the spine, that markers barely determine.
constexpr double kExportSmoothness = 1e-3;

// Returns the scheme with a mapping of the clip's skeleton. An automatic one depends on the motion.
absl::StatusOr<core::MarkerScheme> SchemeOf(const core::MarkerScheme& scheme,
                                            const core::Skeleton& skeleton,
                                            const storage::ClipRecord& clip,
                                            const storage::ClipSource& source,
                                            const WorkOptions& terms) {
  if (core::BindMapping(scheme, core::JointNames(skeleton)).ok()) return scheme;
  MOTIONDB_ASSIGN_OR_RETURN(
      const core::MotionFile file,
      ReadSource(clip.format, {clip.file_name, source.file_bytes},
                 SkeletonFile(clip, source.skeleton_bytes), clip.given, terms));
  return core::FitScheme(scheme, file.motion, core::FitFor::kClip);
}

std::string FitNote(const core::IkMotion& solved) {
  double squared = 0;
  for (const core::IkError& error : solved.errors) squared += error.rms_m * error.rms_m;
  const double count = static_cast<double>(std::max<std::size_t>(1, solved.errors.size()));
  return fmt::format("joint angles fit the stored markers within {:.1f} mm (RMS)",
                     1000 * std::sqrt(squared / count));
}

// Exports one clip.
class Exporter {
 public:
  Exporter(Engine& engine, const storage::ClipRecord& clip, const WorkOptions& terms)
      : engine_(engine), clip_(clip), terms_(terms) {}

  absl::StatusOr<ExportedMotion> Export(core::FileFormat format) {
    MOTIONDB_ASSIGN_OR_RETURN(const auto database, engine_.FindDatabase(clip_.database));
    MOTIONDB_ASSIGN_OR_RETURN(scheme_, database->scheme());
    if (scheme_ == nullptr) return core::FailedPrecondition("the database has no marker set yet");
    MOTIONDB_RETURN_IF_ERROR(Reserve(nullptr));
    MOTIONDB_ASSIGN_OR_RETURN(const core::StateSequence states,
                              engine_.store().ReadClipStates(clip_.database, clip_.id));
    markers_ = {scheme_->set.markers, states.frame_rate_hz, core::WorldPositions(states)};
    leg_length_m_ = states.leg_length_m;
    MOTIONDB_ASSIGN_OR_RETURN(const core::Motion motion, MotionFor(format));
    MOTIONDB_ASSIGN_OR_RETURN(core::WrittenMotion written,
                              core::WriteMotion(format, motion, mimics_));
    ExportedMotion exported{clip_.id + std::string(core::WrittenExtension(format)),
                            std::move(written.bytes), std::move(notes_)};
    std::ranges::move(written.losses, std::back_inserter(exported.notes));
    return exported;
  }

 private:
  // Returns joint angles if the clip has a skeleton and the format has joints, otherwise markers.
  absl::StatusOr<core::Motion> MotionFor(core::FileFormat format) {
    const bool is_robot = clip_.format == core::FileFormat::kCsv;
    const bool has_joints =
        core::HasJoints(format) || (is_robot && format == core::FileFormat::kCsv);
    if (clip_.skeleton_id.empty() || !has_joints) return markers_;
    MOTIONDB_ASSIGN_OR_RETURN(const auto skeleton,
                              engine_.skeletons().Get(clip_.database, clip_.skeleton_id));
    MOTIONDB_ASSIGN_OR_RETURN(const storage::ClipSource source,
                              engine_.store().ReadClipSource(clip_.database, clip_.id));
    if (is_robot) {
      MOTIONDB_ASSIGN_OR_RETURN(core::UrdfRobot robot,
                                core::ReadUrdf({clip_.skeleton_file_name, source.skeleton_bytes}));
      mimics_ = std::move(robot.mimics);
    }
    MOTIONDB_ASSIGN_OR_RETURN(const core::MarkerScheme scheme,
                              SchemeOf(*scheme_, *skeleton, clip_, source, terms_));
    MOTIONDB_RETURN_IF_ERROR(Reserve(skeleton.get()));
    MOTIONDB_ASSIGN_OR_RETURN(const auto kinematics,
                              core::MarkerKinematics::Create(scheme, skeleton, leg_length_m_));
    MOTIONDB_ASSIGN_OR_RETURN(
        core::IkMotion solved,
        core::SolveInverseKinematics(kinematics, markers_, {.smoothness = kExportSmoothness},
                                     terms_.cancelled));
    notes_.push_back(FitNote(solved));
    return std::move(solved.motion);
  }

  // Replaces the reservation of a former step. RESOURCE_EXHAUSTED.
  absl::Status Reserve(const core::Skeleton* skeleton) const {
    constexpr std::int64_t kCoordinate = 6 * (4 + 4 + 12);  // of a marker: state, marker, text
    constexpr std::int64_t kAngle = 2 * 8;
    constexpr std::int64_t kJoint = 160;  // in the longest format, NPZ
    std::int64_t bytes = kCoordinate * scheme_->set.marker_count();
    if (skeleton != nullptr) {
      bytes += kAngle * skeleton->dof_count() + kJoint * skeleton->joint_count();
    }
    return terms_.Reserve(clip_.frame_count * bytes);
  }

  Engine& engine_;
  const storage::ClipRecord& clip_;
  const WorkOptions& terms_;
  std::shared_ptr<const core::MarkerScheme> scheme_;
  core::MarkerMotion markers_;
  double leg_length_m_ = 0;
  core::Mimics mimics_;
  std::vector<std::string> notes_;
};

}  // namespace

absl::Status CheckWrittenFormat(std::string_view field, core::FileFormat format) {
  const core::FormatInfo& info = core::InfoOf(format);
  if (info.is_written) return absl::OkStatus();
  return core::FieldViolation(
      field, "{} files are read only; expected BVH, TRC, C3D, CSV, NPZ or GLTF", info.name);
}

absl::StatusOr<ExportedMotion> ExportMotion(Engine& engine, const storage::ClipRecord& clip,
                                            core::FileFormat format, const WorkOptions& terms) {
  MOTIONDB_RETURN_IF_ERROR(CheckWrittenFormat("format", format));
  if (terms.allowed == AllowedWork::kLightWork) return HeavyWork();
  return Exporter(engine, clip, terms).Export(format);
}

}  // namespace motiondb::server
