#include "core/kinematics/root_velocity.h"

#include <algorithm>
#include <cstdio>

#include "core/format/marker_set_file.h"
#include "core/kinematics/inverse_kinematics.h"
#include "core/motion/states.h"
#include "tests/core/kinematics/figure.h"
#include "tests/support/real_data.h"
#include "tests/support/real_motion.h"

namespace motiondb::tests::root_velocity_test {
namespace {

using core::FrameMatrix;
using core::JointMotion;
using core::MarkerKinematics;
using core::MarkerPose;
using core::PlanarVelocity;
using core::RootVelocity;
using core::SingularityRobustInverse;

// Central differences of the root joint.
RootVelocity MeasuredRootVelocity(const MarkerKinematics& kinematics, const JointMotion& motion,
                                  Eigen::Index frame) {
  MarkerPose before = kinematics.NewPose();
  MarkerPose after = kinematics.NewPose();
  before.angles = motion.angles.row(frame - 1);
  after.angles = motion.angles.row(frame + 1);
  kinematics.Place(before);
  kinematics.Place(after);
  const double per_second = motion.frame_rate_hz / 2;
  const Eigen::AngleAxisd turn(after.world_from_joint[0].linear() *
                               before.world_from_joint[0].linear().transpose());
  return {(after.world_from_joint[0].translation() - before.world_from_joint[0].translation()) *
              per_second,
          turn.angle() * turn.axis() * per_second};
}

// Returns the maximum error of eq. 9 over the motion's inner frames, with central differences of
// the markers.
RootVelocity LargestError(const core::MarkerScheme& scheme, const JointMotion& motion,
                          const std::vector<int>& missing = {}) {
  const MarkerKinematics kinematics = Kinematics(scheme, motion.skeleton);
  FrameMatrix markers = MarkersOf(scheme, motion).positions_m;
  for (const int m : missing) markers.middleCols<3>(3 * m).setConstant(std::nanf(""));
  SingularityRobustInverse inverse(kinematics.dof_count());
  MarkerPose pose = kinematics.NewPose();
  RootVelocity worst;
  for (Eigen::Index frame = 1; frame + 1 < motion.angles.rows(); ++frame) {
    pose.angles = motion.angles.row(frame);
    kinematics.Place(pose);
    kinematics.Differentiate(pose);
    const Eigen::RowVectorXf velocities = (markers.row(frame + 1) - markers.row(frame - 1)) *
                                          static_cast<float>(motion.frame_rate_hz / 2);
    const RootVelocity solved = core::SolveRootVelocity(kinematics, pose, velocities, inverse);
    const RootVelocity measured = MeasuredRootVelocity(kinematics, motion, frame);
    worst.linear = worst.linear.cwiseMax((solved.linear - measured.linear).cwiseAbs());
    worst.angular = worst.angular.cwiseMax((solved.angular - measured.angular).cwiseAbs());
  }
  return worst;
}

// Converts the root velocity of eq. 9 to the velocity of the reference frame: root joint, hips and
// frame move as one rigid body. Leg lengths/s and rad/s; the pose is in the frame.
PlanarVelocity InReferenceFrame(const RootVelocity& root, const core::Landmarks& hips,
                                const MarkerPose& pose, double leg_length_m) {
  const Eigen::Vector3d left = pose.markers_m.col(hips.left_hip);
  const Eigen::Vector3d right = pose.markers_m.col(hips.right_hip);
  const Eigen::Vector3d across = left - right;
  const Eigen::Vector3d turning = root.angular.cross(across);
  const Eigen::Vector3d arm = 0.5 * (left + right) - pose.world_from_joint[0].translation();
  const Eigen::Vector3d moving = (root.linear + root.angular.cross(arm)) / leg_length_m;
  return {moving.x(), moving.y(),
          (across.x() * turning.y() - across.y() * turning.x()) / across.head<2>().squaredNorm()};
}

// Compares eq. 9, on the pose that inverse kinematics finds for a state, with the velocity of the
// hips.
class VelocityComparison {
 public:
  VelocityComparison(const core::MarkerScheme& scheme,
                     std::shared_ptr<const core::Skeleton> skeleton)
      : set_(scheme.set),
        kinematics_(Kinematics(scheme, skeleton)),
        leg_length_m_(core::SkeletonLegLength(scheme, skeleton).value()),
        tracker_(kinematics_, {}),
        inverse_(kinematics_.dof_count()) {}

  void Add(const Eigen::RowVectorXf& state) {
    const int markers = set_.marker_count();
    Eigen::RowVectorXf positions(3 * markers);
    Eigen::RowVectorXf velocities(3 * markers);
    for (int m = 0; m < markers; ++m) {
      positions.segment<3>(3 * m) = static_cast<float>(leg_length_m_) * state.segment<3>(6 * m);
      velocities.segment<3>(3 * m) =
          static_cast<float>(leg_length_m_) * state.segment<3>(6 * m + 3);
    }
    fit_m_.push_back(tracker_.Follow(positions).rms_m);
    MarkerPose pose = tracker_.pose();
    kinematics_.Differentiate(pose);
    const RootVelocity root = core::SolveRootVelocity(kinematics_, pose, velocities, inverse_);
    const PlanarVelocity all = InReferenceFrame(root, set_.landmarks, pose, leg_length_m_);
    const PlanarVelocity hips = core::RootVelocityFromHips(set_, state);
    speed_apart_.push_back(std::hypot(all.x - hips.x, all.y - hips.y));
    yaw_apart_.push_back(std::abs(all.yaw_rate - hips.yaw_rate));
  }

  double speed_apart(double share) const { return Quantile(speed_apart_, share); }
  double yaw_apart(double share) const { return Quantile(yaw_apart_, share); }

  void Print(const char* what) const {
    std::printf(
        "%s, %zu states, eq. 9 against the hips, median / 95 %% / largest: "
        "%.4f / %.4f / %.4f leg lengths/s, %.4f / %.4f / %.4f rad/s; "
        "poses fit to %.2f cm rms (median), %.2f (largest)\n",
        what, speed_apart_.size(), speed_apart(0.5), speed_apart(0.95), speed_apart(1),
        yaw_apart(0.5), yaw_apart(0.95), yaw_apart(1), 100 * Quantile(fit_m_, 0.5),
        100 * Quantile(fit_m_, 1));
  }

 private:
  static double Quantile(std::vector<double> values, double share) {
    const auto at = values.begin() +
                    static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
  }

  core::MarkerSet set_;
  MarkerKinematics kinematics_;
  double leg_length_m_;
  core::PoseTracker tracker_;
  SingularityRobustInverse inverse_;
  std::vector<double> speed_apart_;
  std::vector<double> yaw_apart_;
  std::vector<double> fit_m_;
};

}  // namespace

TEST_CASE("RootVelocityFromHips: integrates to the reference frame's own path",
          "[core][kinematics]") {
  const auto skeleton = Figure();
  const auto markers = MarkersOf(FigureScheme(), Swing(skeleton, 600, 600));
  const auto states = core::ComputeStates(FigureScheme().set, markers);
  REQUIRE(states.ok());
  const core::RootPath& path = states->root_path;
  for (Eigen::Index frame = 1; frame + 1 < path.rows(); ++frame) {
    const PlanarVelocity velocity =
        core::RootVelocityFromHips(FigureScheme().set, states->states.row(frame));
    const Eigen::RowVector3d rate = (path.row(frame + 1) - path.row(frame - 1)) * (600 / 2);
    const Eigen::Vector2d moving = Eigen::Rotation2Dd(path(frame, 2)) *
                                   Eigen::Vector2d(velocity.x, velocity.y) * states->leg_length_m;
    CHECK((moving - rate.head<2>().transpose()).norm() < 2e-3);
    CHECK(velocity.yaw_rate == Approx(rate[2]).margin(2e-2));
  }
}

TEST_CASE("RootVelocityFromHips: hips that rotate about a point on the floor",
          "[core][kinematics]") {
  core::MarkerSet set{"hips", {"left", "other", "right"}, {0, 2, {}}};
  Eigen::RowVectorXf state = Eigen::RowVectorXf::Zero(18);
  state.segment<3>(0) << 0, 0.5F, 1;
  state.segment<3>(12) << 0, -0.5F, 1.2F;
  // 0.3 rad/s about (0, 2): the middle moves forward at 0.6.
  state.segment<3>(3) << 0.45F, 0, 9;
  state.segment<3>(15) << 0.75F, 0, -9;
  const PlanarVelocity velocity = core::RootVelocityFromHips(set, state);
  CHECK(velocity.x == Approx(0.6));
  CHECK(velocity.y == Approx(0).margin(1e-7));
  CHECK(velocity.yaw_rate == Approx(0.3));
  SECTION("one hip above the other: no rotation") {
    state[1] = state[13] = 0;
    CHECK(core::RootVelocityFromHips(set, state).yaw_rate == 0);
  }
  SECTION("a hip is missing") {
    state.segment<6>(0).setConstant(std::nanf(""));
    CHECK(std::isnan(core::RootVelocityFromHips(set, state).x));
    CHECK(std::isnan(core::RootVelocityFromHips(set, state).yaw_rate));
  }
}

TEST_CASE("Root velocity: eq. 9 and the hips agree on a synthetic motion", "[core][kinematics]") {
  const auto skeleton = Figure();
  const auto markers = MarkersOf(FigureScheme(), Swing(skeleton, 300, 600));
  const auto states = core::ComputeStates(FigureScheme().set, markers);
  REQUIRE(states.ok());
  VelocityComparison comparison(FigureScheme(), skeleton);
  for (Eigen::Index frame = 1; frame + 1 < 300; ++frame) comparison.Add(states->states.row(frame));
  CHECK(comparison.speed_apart(1) < 0.02);
  CHECK(comparison.yaw_apart(1) < 0.05);
}

TEST_CASE("Root velocity: eq. 9 and the hips agree on real walking", "[core][kinematics][data]") {
  MOTIONDB_REQUIRE_DATA();
  const std::filesystem::path clip = DataDir() / "cmu/16/16_18.amc";
  const auto skeleton = std::get<JointMotion>(LoadMotion(clip).motion).skeleton;
  SECTION("on a clip's own frames") {
    VelocityComparison comparison(core::StandardScheme(), skeleton);
    const core::StateSequence states = LoadStates(clip, 60);
    for (Eigen::Index frame = 1; frame + 1 < states.frame_count(); ++frame) {
      comparison.Add(states.states.row(frame));
    }
    comparison.Print("16_18 at 60 Hz");
    CHECK(comparison.speed_apart(0.95) < 0.05);
    CHECK(comparison.yaw_apart(0.95) < 0.2);
  }
  SECTION("on the means of the bottom nodes") {
    const core::Model model = BuildFromList(DataDir() / "sets/database2.tsv", {});
    core::FrameMatrix means = model.gaussians().means();
    model.scale().Revert(means);
    VelocityComparison comparison(core::StandardScheme(), skeleton);
    const int bottom = model.layer_count();
    for (int node = 0; node < model.tree().node_count(bottom); ++node) {
      comparison.Add(means.row(model.tree().branch(bottom, node)));
    }
    comparison.Print("bottom nodes of database2 at 60 Hz");
    CHECK(comparison.speed_apart(0.95) < 0.1);
    CHECK(comparison.yaw_apart(0.95) < 0.5);
  }
}

TEST_CASE("SolveRootVelocity: equals the velocity of a known motion", "[core][kinematics]") {
  // At 1000 Hz; single precision of positions alone causes 1e-4 m/s.
  const RootVelocity error = LargestError(FigureScheme(), Swing(Figure(), 2000, 1000));
  CHECK(error.linear.maxCoeff() < 5e-3);
  CHECK(error.angular.maxCoeff() < 2e-2);
}

TEST_CASE("SolveRootVelocity: markers without a velocity are ignored", "[core][kinematics]") {
  const RootVelocity error = LargestError(FigureScheme(), Swing(Figure(), 500, 1000), {3, 12});
  CHECK(error.linear.maxCoeff() < 5e-3);
  CHECK(error.angular.maxCoeff() < 2e-2);
}

TEST_CASE("SolveRootVelocity: a rigidly rotating body", "[core][kinematics]") {
  const auto skeleton = Figure();
  const MarkerKinematics kinematics = Kinematics(FigureScheme(), skeleton);
  MarkerPose pose = kinematics.NewPose();
  pose.angles = Swing(skeleton, 1).angles.row(0);
  kinematics.Place(pose);
  kinematics.Differentiate(pose);
  const Eigen::Vector3d linear(0.5, -1, 0.2);
  const Eigen::Vector3d angular(0.1, 0.3, -2);
  Eigen::RowVectorXf velocities(3 * kinematics.marker_count());
  for (int m = 0; m < kinematics.marker_count(); ++m) {
    const Eigen::Vector3d arm = pose.markers_m.col(m) - pose.world_from_joint[0].translation();
    const Eigen::Vector3d velocity = linear + angular.cross(arm);
    velocities.segment<3>(3 * m) = velocity.transpose().cast<float>();
  }
  SingularityRobustInverse inverse(kinematics.dof_count());
  const RootVelocity root = core::SolveRootVelocity(kinematics, pose, velocities, inverse);
  CHECK((root.linear - linear).norm() < 1e-5);
  CHECK((root.angular - angular).norm() < 1e-4);
}

TEST_CASE("SolveRootVelocity: real walking", "[core][kinematics][data]") {
  MOTIONDB_REQUIRE_DATA();
  const auto file = LoadMotion(DataDir() / "cmu/02/02_01.amc");
  const RootVelocity error =
      LargestError(core::StandardScheme(), std::get<JointMotion>(file.motion));
  WARN("02_01, 120 Hz: root velocity by eq. 9 within " << error.linear.maxCoeff() << " m/s and "
                                                       << error.angular.maxCoeff() << " rad/s");
  CHECK(error.linear.maxCoeff() < 0.05);
  CHECK(error.angular.maxCoeff() < 0.5);
}

}  // namespace motiondb::tests::root_velocity_test
