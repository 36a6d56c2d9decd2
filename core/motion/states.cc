#include "core/motion/states.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/motion/corrections.h"
#include "core/motion/error.h"
#include "core/motion/frame_state.h"
#include "core/motion/marker_set.h"
#include "core/motion/motion_floor.h"
#include "core/motion/samples.h"

namespace motiondb::core {

namespace {

constexpr double kMaxGapSeconds = 0.5;

// Larger values are no human motion, and squares of states would overflow a float.
constexpr float kMaxPosition_m = 1e5F;
constexpr double kMinLeg_m = 1e-3;
constexpr double kMaxLeg_m = 1e4;

using MarkerRow = Eigen::Matrix<float, 1, 3>;

MarkerRow At(const MarkerMotion& motion, Eigen::Index frame, int marker) {
  return motion.positions_m.row(frame).segment<3>(3 * marker);
}

// Median of the finite values; NaN if there is none.
double MedianOfFinite(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  return values.empty() ? std::nan("") : Median(values);
}

Eigen::Matrix2d FloorRotation(double heading) {
  return Eigen::Rotation2Dd(heading).toRotationMatrix();
}

// Interpolates rows without a pose between the nearest rows that have one.
void Interpolate(const std::vector<bool>& valid, RootPath& path) {
  const auto frames = static_cast<Eigen::Index>(valid.size());
  Eigen::Index before = -1;
  for (Eigen::Index t = 0; t <= frames; ++t) {
    if (t < frames && !valid[t]) continue;
    for (Eigen::Index g = before + 1; g < t; ++g) {
      if (before < 0) {
        path.row(g) = path.row(t);
      } else if (t == frames) {
        path.row(g) = path.row(before);
      } else {
        const double share = static_cast<double>(g - before) / static_cast<double>(t - before);
        path.row(g) = (1 - share) * path.row(before) + share * path.row(t);
      }
    }
    before = t;
  }
}

// Leaves out a reference pose at the start.
void DropPoseAtStart(const MarkerSet& set, double leg_length_m, MarkerMotion& motion,
                     std::vector<std::string>& notes) {
  const PoseAtStart start = FindPoseAtStart(set, motion, leg_length_m);
  if (start.frame_count == 0) return;
  notes.push_back(fmt::format("{}-pose at the start left out: frames 1-{} of {}",
                              start.pose == ReferencePose::kT ? "T" : "A", start.frame_count,
                              motion.positions_m.rows()));
  motion.positions_m =
      motion.positions_m.bottomRows(motion.positions_m.rows() - start.frame_count).eval();
  motion.first_frame += start.frame_count;
}

// Prepares a motion relative to `origin` for storage: leaves out a reference pose, applies the
// glitch policy and derives markers. Returns the remaining glitches.
absl::StatusOr<std::vector<FrameSpan>> CleanMotion(GlitchPolicy policy, const MarkerSet& set,
                                                   const Eigen::Vector2d& origin,
                                                   double leg_length_m, MarkerMotion& motion,
                                                   std::vector<std::string>& notes) {
  std::vector<FrameSpan> glitches;
  // ComputeStates rejects other leg lengths later.
  if (!(leg_length_m >= kMinLeg_m && leg_length_m <= kMaxLeg_m)) return glitches;
  DropPoseAtStart(set, leg_length_m, motion, notes);
  MOTIONDB_ASSIGN_OR_RETURN(
      glitches,
      ApplyGlitchPolicy(policy, FindGlitches(motion, leg_length_m, origin), motion, notes));
  MOTIONDB_RETURN_IF_ERROR(AddDerivedMarkers(set, leg_length_m, motion, notes));
  return glitches;
}

// `motion` is relative to `origin`.
absl::Status CheckPositions(const Eigen::Vector2d& origin, const MarkerMotion& motion) {
  const Eigen::RowVector3d from(origin.x(), origin.y(), 0);
  // Positions within `near` are within the limit in the world.
  const auto near = static_cast<float>(kMaxPosition_m - from.cwiseAbs().maxCoeff());
  for (Eigen::Index t = 0; t < motion.positions_m.rows(); ++t) {
    if (!(motion.positions_m.row(t).array().abs() > near).any()) continue;
    for (int m = 0; m < static_cast<int>(motion.names.size()); ++m) {
      const Eigen::RowVector3d at = At(motion, t, m).cast<double>() + from;
      if (!(at.array().abs() > kMaxPosition_m).any()) continue;
      return InvalidArgument(
          "frame {}, marker '{}': expected positions up to {} m, got ({}, {}, {})",
          motion.first_frame + t + 1, motion.names[m], kMaxPosition_m, at[0], at[1], at[2]);
    }
  }
  return absl::OkStatus();
}

// Returns the leg length of the skeleton with all rotations zero. Joints that move relative to
// their parents are where they are in the first frame.
absl::StatusOr<double> RestLegLength(const MarkerScheme& scheme, const JointMotion& motion) {
  const Skeleton& skeleton = *motion.skeleton;
  JointMotion rest{motion.skeleton, 1, JointMatrix::Zero(1, skeleton.dof_count())};
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    const Joint& joint = skeleton.joints()[j];
    for (std::size_t k = 0; k < joint.dofs.size(); ++k) {
      if (joint.parent < 0 || joint.dofs[k].kind != Dof::Kind::kTranslation) continue;
      const int dof = skeleton.first_dof(j) + static_cast<int>(k);
      rest.angles(0, dof) = motion.angles(0, dof);
    }
  }
  // Offsets scale with the result, so measure without them.
  MOTIONDB_ASSIGN_OR_RETURN(const MarkerMotion markers, ApplyScheme(scheme, rest, 0.0));
  return EstimateLegLength(scheme.set, markers);
}

// Returns INVALID_ARGUMENT, naming the source marker, if a marker of the set is missing in all
// frames because a source marker is.
absl::Status CheckSourceMarkers(const MarkerScheme& scheme, const MarkerMotion& source,
                                const MarkerMotion& mapped) {
  const auto is_missing = [](const MarkerMotion& motion, int marker) {
    return motion.positions_m.col(3 * marker).array().isNaN().all();
  };
  for (int m = 0; m < scheme.set.marker_count(); ++m) {
    if (!is_missing(mapped, m)) continue;
    MOTIONDB_ASSIGN_OR_RETURN(const BoundMapping mapping, BindMapping(scheme, source.names));
    for (const auto& [point, weight] : mapping.rules[m].points) {
      if (!is_missing(source, point) || source.names[point] == mapped.names[m]) continue;
      return InvalidArgument("'{}' is missing in all {} frames, so marker '{}' is",
                             source.names[point], source.positions_m.rows(), mapped.names[m]);
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<double> EstimateLegLength(const MarkerSet& set, const MarkerMotion& motion) {
  double sum = 0;
  int count = 0;
  for (const auto& [hip, knee, ankle] : set.landmarks.legs) {
    std::vector<double> lengths;
    for (Eigen::Index t = 0; t < motion.positions_m.rows(); ++t) {
      lengths.push_back((At(motion, t, hip) - At(motion, t, knee)).norm() +
                        (At(motion, t, knee) - At(motion, t, ankle)).norm());
    }
    if (const double length = MedianOfFinite(std::move(lengths)); length > 0) {
      sum += length;
      ++count;
    }
  }
  if (count > 0) return sum / count;

  std::vector<double> heights;
  for (Eigen::Index t = 0; t < motion.positions_m.rows(); ++t) {
    std::vector<double> z;
    z.reserve(set.markers.size());
    for (int m = 0; m < set.marker_count(); ++m) z.push_back(At(motion, t, m)[2]);
    const double lowest = *std::min_element(z.begin(), z.end(), [](double a, double b) {
      return a < b || (std::isnan(b) && !std::isnan(a));
    });
    heights.push_back(MedianOfFinite(std::move(z)) - lowest);
  }
  const double height = MedianOfFinite(std::move(heights));
  if (!(height > 0)) {
    return InvalidArgument("cannot estimate the subject's size from its markers; set leg_length_m");
  }
  return height / 2;
}

absl::StatusOr<double> SkeletonLegLength(const MarkerScheme& scheme,
                                         const std::shared_ptr<const Skeleton>& skeleton) {
  return RestLegLength(scheme, {skeleton, 1, JointMatrix::Zero(1, skeleton->dof_count())});
}

absl::StatusOr<RootPath> ReferenceFrames(const MarkerSet& set, const MarkerMotion& motion) {
  const Landmarks& landmarks = set.landmarks;
  if (landmarks.left_hip < 0 || landmarks.right_hip < 0) {
    return InvalidArgument("marker set '{}' does not name the hip markers", set.name);
  }
  const Eigen::Index frames = motion.positions_m.rows();
  RootPath path(frames, 3);
  std::vector<bool> placed(frames);
  std::vector<bool> turned(frames);
  bool any = false;
  double heading = 0;
  for (Eigen::Index t = 0; t < frames; ++t) {
    const HipLine hips = ReadHips(At(motion, t, landmarks.left_hip).cast<double>().transpose(),
                                  At(motion, t, landmarks.right_hip).cast<double>().transpose());
    placed[t] = hips.placed;
    turned[t] = hips.turned;
    if (placed[t]) path.row(t).head<2>() = hips.middle.transpose();
    if (!turned[t]) continue;
    const double raw = hips.heading;
    heading = any ? heading + std::remainder(raw - heading, 2 * std::numbers::pi)
                  : std::remainder(raw, 2 * std::numbers::pi);
    path(t, 2) = heading;
    any = true;
  }
  if (!any && std::ranges::find(placed, true) != placed.end()) {
    return InvalidArgument(
        "'{}' and '{}' are above each other in all frames: check the up axis (up_axis, --up-axis)",
        set.markers[landmarks.left_hip], set.markers[landmarks.right_hip]);
  }
  if (!any) {
    return InvalidArgument("no frame has both hips, '{}' and '{}': root and front are unknown",
                           set.markers[landmarks.left_hip], set.markers[landmarks.right_hip]);
  }
  RootPath headings = path;
  Interpolate(placed, path);
  Interpolate(turned, headings);
  path.col(2) = headings.col(2);
  return path;
}

absl::StatusOr<StateSequence> ComputeStates(const MarkerSet& set, const MarkerMotion& motion,
                                            std::optional<double> leg_length_m) {
  const Eigen::Index frames = motion.positions_m.rows();
  if (frames == 0 || motion.positions_m.cols() != 3 * set.marker_count()) {
    return InvalidArgument("expected frames of {} markers, got {} frames of {} numbers",
                           set.marker_count(), frames, motion.positions_m.cols());
  }
  if (leg_length_m && !(*leg_length_m > 0 && std::isfinite(*leg_length_m))) {
    return InvalidArgument("leg_length_m: expected more than 0, got {}", *leg_length_m);
  }
  StateSequence sequence;
  sequence.frame_rate_hz = motion.frame_rate_hz;
  MOTIONDB_ASSIGN_OR_RETURN(sequence.root_path, ReferenceFrames(set, motion));
  if (leg_length_m) {
    sequence.leg_length_m = *leg_length_m;
  } else {
    MOTIONDB_ASSIGN_OR_RETURN(sequence.leg_length_m, EstimateLegLength(set, motion));
  }
  if (!(sequence.leg_length_m >= kMinLeg_m && sequence.leg_length_m <= kMaxLeg_m)) {
    return InvalidArgument("leg_length_m: expected {} to {}, got {}", kMinLeg_m, kMaxLeg_m,
                           sequence.leg_length_m);
  }

  sequence.states.resize(frames, set.dimension_count());
  for (Eigen::Index t = 0; t < frames; ++t) {
    const auto marker_at = [&](int offset, Eigen::Index m) -> Eigen::Vector3d {
      const Eigen::Index n = t + offset;
      if (n < 0 || n >= frames) return Eigen::Vector3d::Constant(std::nan(""));
      return At(motion, n, static_cast<int>(m)).cast<double>().transpose();
    };
    MakeFrameState(marker_at, sequence.root_path.row(t).transpose(), motion.frame_rate_hz,
                   sequence.leg_length_m, sequence.states.row(t));
  }
  return sequence;
}

absl::StatusOr<StateSequence> Represent(const MarkerScheme& scheme, const Motion& motion,
                                        double frame_rate_hz, Cleaning cleaning,
                                        std::optional<double> leg_length_m,
                                        std::vector<std::string>* notes, const Cancelled& cancelled,
                                        SourcePart* part) {
  const auto check_cancelled = [&] {
    return cancelled && cancelled() ? absl::CancelledError("computing the states was cancelled")
                                    : absl::OkStatus();
  };
  const auto* const joints = std::get_if<JointMotion>(&motion);
  const bool has_bones = joints != nullptr && joints->angles.rows() > 0;
  if (!leg_length_m && has_bones && !scheme.set.landmarks.legs.empty()) {
    MOTIONDB_ASSIGN_OR_RETURN(leg_length_m, RestLegLength(scheme, *joints));
  }
  const Eigen::Vector2d origin = FloorOrigin(motion);
  MOTIONDB_ASSIGN_OR_RETURN(MarkerMotion mapped,
                            ApplySchemeFrom(origin, scheme, motion, leg_length_m, cancelled));
  const int first_frame = mapped.first_frame;
  // ComputeStates estimates the size again, from the resampled motion, and reports errors.
  const absl::StatusOr<double> size_m =
      leg_length_m ? *leg_length_m : EstimateLegLength(scheme.set, mapped);
  // After the mapping, because only markers in use must be complete.
  std::vector<FrameSpan> glitches;
  std::vector<std::string> found;
  if (cleaning) {
    MOTIONDB_RETURN_IF_ERROR(size_m.status());
    MOTIONDB_ASSIGN_OR_RETURN(glitches,
                              CleanMotion(*cleaning, scheme.set, origin, *size_m, mapped, found));
  } else if (size_m.ok()) {
    ReplacePoseAtStart(scheme.set, *size_m, mapped);
  }
  MOTIONDB_RETURN_IF_ERROR(CheckPositions(origin, mapped));
  if (cleaning) {
    if (const auto* const markers = std::get_if<MarkerMotion>(&motion)) {
      MOTIONDB_RETURN_IF_ERROR(CheckSourceMarkers(scheme, *markers, mapped));
    }
    MOTIONDB_ASSIGN_OR_RETURN(const auto filled, FillGaps(kMaxGapSeconds, mapped));
    found.insert(found.end(), filled.begin(), filled.end());
  }
  if (notes != nullptr) notes->insert(notes->end(), found.begin(), found.end());
  MOTIONDB_RETURN_IF_ERROR(check_cancelled());
  const double floor_m = size_m.ok() ? MoveToFloor(scheme.set, *size_m, mapped) : 0;
  if (part != nullptr) {
    *part = {mapped.first_frame - first_frame, static_cast<int>(mapped.positions_m.rows()),
             floor_m};
  }
  MOTIONDB_ASSIGN_OR_RETURN(const MarkerMotion resampled, Resample(mapped, frame_rate_hz));
  const double source_rate_hz = mapped.frame_rate_hz;
  mapped = {};
  MOTIONDB_RETURN_IF_ERROR(check_cancelled());
  MOTIONDB_ASSIGN_OR_RETURN(StateSequence states,
                            ComputeStates(scheme.set, resampled, leg_length_m));
  states.root_path.leftCols<2>().rowwise() += origin.transpose();
  if (!cleaning) states.floor_m = floor_m;
  states.glitches = AtFrameRate(glitches, source_rate_hz, frame_rate_hz, states.frame_count());
  return states;
}

FrameMatrix WorldPositions(const StateSequence& sequence) {
  const Eigen::Index markers = sequence.states.cols() / 6;
  FrameMatrix positions(sequence.states.rows(), 3 * markers);
  for (Eigen::Index t = 0; t < sequence.states.rows(); ++t) {
    const Eigen::Matrix2d turn = FloorRotation(sequence.root_path(t, 2));
    for (Eigen::Index m = 0; m < markers; ++m) {
      Eigen::Vector3d p = sequence.leg_length_m *
                          sequence.states.row(t).segment<3>(6 * m).cast<double>().transpose();
      p.head<2>() = turn * p.head<2>();
      p.head<2>() += sequence.root_path.row(t).head<2>().transpose();
      p.z() += sequence.floor_m;
      positions.row(t).segment<3>(3 * m) = p.cast<float>().transpose();
    }
  }
  return positions;
}

StateSequence PastAt(const StateSequence& observation, int frame, int history) {
  const int count = std::min(history, frame + 1);
  const int first = frame + 1 - count;
  StateSequence past{observation.frame_rate_hz, observation.leg_length_m,
                     observation.states.middleRows(first, count),
                     observation.root_path.middleRows(first, count)};
  past.floor_m = observation.floor_m;
  if (frame == 0 || frame + 1 == observation.frame_count()) return past;

  StateSequence last_two{observation.frame_rate_hz, observation.leg_length_m,
                         observation.states.middleRows(frame - 1, 2),
                         observation.root_path.middleRows(frame - 1, 2)};
  const Eigen::Vector2d origin = NearestCorner(last_two.root_path.row(0).head<2>().transpose());
  last_two.root_path.leftCols<2>().rowwise() -= origin.transpose();
  const FrameMatrix positions = WorldPositions(last_two);
  const double c = std::cos(observation.root_path(frame, 2));
  const double s = std::sin(observation.root_path(frame, 2));
  const auto to_states = static_cast<float>(observation.frame_rate_hz / observation.leg_length_m);
  for (Eigen::Index m = 0; m < positions.cols() / 3; ++m) {
    const Eigen::RowVector3f v =
        (positions.row(1) - positions.row(0)).segment<3>(3 * m) * to_states;
    past.states.row(count - 1).segment<3>(6 * m + 3) << static_cast<float>(c * v.x() + s * v.y()),
        static_cast<float>(-s * v.x() + c * v.y()), v.z();
  }
  return past;
}

}  // namespace motiondb::core
