#include "core/kinematics/inverse_kinematics.h"

#include <limits>

#include "tests/core/kinematics/figure.h"

namespace motiondb::tests::inverse_kinematics_test {
namespace {

using core::IkMotion;
using core::JointMotion;
using core::MarkerKinematics;
using core::MarkerMotion;
using core::Skeleton;

IkMotion Solve(const MarkerKinematics& kinematics, const MarkerMotion& markers,
               const core::IkOptions& options = {}) {
  auto solved = core::SolveInverseKinematics(kinematics, markers, options);
  INFO(solved.status());
  REQUIRE(solved.ok());
  REQUIRE(solved->motion.angles.rows() == markers.positions_m.rows());
  REQUIRE(solved->errors.size() == static_cast<std::size_t>(markers.positions_m.rows()));
  return *std::move(solved);
}

double LargestError(const IkMotion& solved) {
  double largest = 0;
  for (const core::IkError& error : solved.errors) largest = std::max(largest, error.largest_m);
  return largest;
}

// An arm of two links of 1 m each in the plane z = 0, with a reach of 2 m.
std::shared_ptr<const Skeleton> Arm(double elbow_lower, double elbow_upper) {
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  auto skeleton = Skeleton::Create("arm", {{.name = "shoulder", .dofs = {Turn(z)}},
                                           {.name = "elbow",
                                            .parent = 0,
                                            .offset_m = {1, 0, 0},
                                            .dofs = {Turn(z, elbow_lower, elbow_upper)}},
                                           {.name = "hand", .parent = 1, .offset_m = {1, 0, 0}}});
  REQUIRE(skeleton.ok());
  return std::make_shared<Skeleton>(*std::move(skeleton));
}

core::MarkerScheme HandScheme() {
  core::MarkerScheme scheme;
  scheme.set = {.name = "hand", .markers = {"hand"}, .landmarks = {}};
  return scheme;
}

}  // namespace

TEST_CASE("SolveInverseKinematics: markers of a synthetic motion are reproduced",
          "[core][kinematics]") {
  const auto skeleton = Figure();
  const MarkerMotion markers = MarkersOf(FigureScheme(), Swing(skeleton, 300));
  const MarkerKinematics kinematics = Kinematics(FigureScheme(), skeleton);
  const IkMotion solved = Solve(kinematics, markers);
  CHECK(LargestError(solved) < 1e-3);
  CHECK(core::CountLimitViolations(solved.motion, 0) == 0);
  CHECK((MarkersOf(FigureScheme(), solved.motion).positions_m - markers.positions_m)
            .cwiseAbs()
            .maxCoeff() < 1e-3F);
  SECTION("the same twice") {
    CHECK(Solve(kinematics, markers).motion.angles == solved.motion.angles);
  }
}

TEST_CASE("SolveInverseKinematics: a root that turns through gimbal lock", "[core][kinematics]") {
  const auto skeleton = Figure();
  JointMotion motion = Swing(skeleton, 200);
  for (int frame = 0; frame < 200; ++frame) motion.angles(frame, 4) = 0.02 * frame;
  const IkMotion solved =
      Solve(Kinematics(FigureScheme(), skeleton), MarkersOf(FigureScheme(), motion));
  CHECK(LargestError(solved) < 1e-3);
}

TEST_CASE("SolveInverseKinematics: missing markers are ignored", "[core][kinematics]") {
  const auto skeleton = Figure();
  const MarkerMotion whole = MarkersOf(FigureScheme(), Swing(skeleton, 100));
  const MarkerKinematics kinematics = Kinematics(FigureScheme(), skeleton);
  MarkerMotion holes = whole;
  const float missing = std::numeric_limits<float>::quiet_NaN();
  holes.positions_m.topRows(3).setConstant(missing);
  for (int frame = 3; frame < 100; ++frame) {
    const int marker = frame / 5 % kinematics.marker_count();
    holes.positions_m.row(frame).segment<3>(3 * marker).setConstant(missing);
  }
  holes.positions_m.row(50).setConstant(missing);
  const IkMotion solved = Solve(kinematics, holes);
  CHECK(solved.motion.angles.allFinite());
  CHECK(LargestError(solved) < 1e-3);
  CHECK(solved.motion.angles.row(0) == solved.motion.angles.row(3));
  CHECK(solved.motion.angles.row(50) == solved.motion.angles.row(49));
  CHECK(solved.errors[50].rms_m == 0);
}

TEST_CASE("SolveInverseKinematics: returns the nearest pose if targets are out of reach",
          "[core][kinematics]") {
  MarkerMotion hand{{"hand"}, 60, {}};
  hand.positions_m.resize(4, 3);
  hand.positions_m << 1.5F, 0.5F, 0, 0, 3, 0, -1e6F, 0, 0, 0.1F, 0.1F, 5;
  SECTION("an arm that is too short points at the target") {
    const MarkerKinematics kinematics = Kinematics(HandScheme(), Arm(-3, 3));
    const IkMotion solved = Solve(kinematics, hand);
    CHECK(solved.errors[0].largest_m < 1e-5);
    CHECK(solved.errors[1].largest_m == Approx(1).margin(1e-3));
    CHECK(solved.motion.angles.allFinite());
    CHECK(solved.errors[2].largest_m == Approx(1e6 - 2).margin(1));
  }
  SECTION("an elbow at its limit stays there") {
    const MarkerKinematics kinematics = Kinematics(HandScheme(), Arm(0.5, 1.0));
    const IkMotion solved = Solve(kinematics, hand);
    CHECK(core::CountLimitViolations(solved.motion, 0) == 0);
    // The hand is furthest from the shoulder with the elbow as straight as its limit allows.
    const double reach = 2 * std::cos(0.25);
    CHECK(solved.motion.angles(1, 1) == 0.5);
    CHECK(solved.errors[1].largest_m == Approx(3 - reach).margin(1e-3));
  }
}

TEST_CASE("SolveInverseKinematics: random targets keep poses finite and within limits",
          "[core][kinematics]") {
  const auto skeleton = GENERATE(true, false) ? Figure() : RobotLegs();
  const auto scheme = skeleton->name() == "figure" ? FigureScheme() : RobotScheme();
  const MarkerKinematics kinematics = Kinematics(scheme, skeleton);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> number(-3, 3);
  MarkerMotion targets{kinematics.marker_names(), 60, {}};
  targets.positions_m = core::FrameMatrix::NullaryExpr(40, 3 * kinematics.marker_count(),
                                                       [&] { return number(random); });
  const IkMotion solved = Solve(kinematics, targets);
  CHECK(solved.motion.angles.allFinite());
  CHECK(core::CountLimitViolations(solved.motion, 0) == 0);
  for (const core::IkError& error : solved.errors) CHECK(error.largest_m >= error.rms_m);
}

TEST_CASE("SolveInverseKinematics: a marker with a larger weight has a smaller error",
          "[core][kinematics]") {
  // Markers of a body that is 10 % larger, which cannot be met.
  const auto skeleton = Figure();
  const MarkerKinematics kinematics = Kinematics(FigureScheme(), skeleton);
  MarkerMotion markers = MarkersOf(FigureScheme(), Swing(skeleton, 60));
  markers.positions_m *= 1.1F;
  const int ankle = 2;
  const auto ankle_error = [&](const core::IkOptions& options) {
    const IkMotion solved = Solve(kinematics, markers, options);
    const auto found = MarkersOf(FigureScheme(), solved.motion).positions_m;
    return (found - markers.positions_m).middleCols<3>(3 * ankle).rowwise().norm().mean();
  };
  core::IkOptions options;
  const double unweighted_error = ankle_error(options);
  options.marker_weights.assign(kinematics.marker_names().size(), 1);
  CHECK(ankle_error(options) == Approx(unweighted_error));
  options.marker_weights[ankle] = 100;
  CHECK(ankle_error(options) < 0.2 * unweighted_error);
  SECTION("only ratios count") {
    core::IkOptions tenfold = options;
    for (double& weight : tenfold.marker_weights) weight *= 10;
    CHECK(ankle_error(tenfold) == Approx(ankle_error(options)));
  }
}

TEST_CASE("SolveInverseKinematics: angles are continuous over full turns", "[core][kinematics]") {
  const auto skeleton = Figure();
  JointMotion motion = Swing(skeleton, 400);
  const int turn = 3;  // about the vertical, three full turns
  for (int frame = 0; frame < 400; ++frame) motion.angles(frame, turn) = 0.047 * frame;
  motion.angles.middleCols<2>(4) *= 0.3;
  const IkMotion solved =
      Solve(Kinematics(FigureScheme(), skeleton), MarkersOf(FigureScheme(), motion));
  const auto& angles = solved.motion.angles;
  CHECK((angles.bottomRows(399) - angles.topRows(399)).cwiseAbs().maxCoeff() < 0.3);
  CHECK(angles(399, turn) - angles(0, turn) == Approx(0.047 * 399).margin(0.01));
}

TEST_CASE("SolveInverseKinematics: unreachable markers cause no jumps", "[core][kinematics]") {
  // Those of a body that is 10 % larger: poses with bent and with straight legs are equally near.
  const auto skeleton = RobotLegs();
  const JointMotion motion = Swing(skeleton, 400);
  MarkerMotion markers = MarkersOf(RobotScheme(), motion);
  markers.positions_m *= 1.1F;
  const IkMotion solved = Solve(Kinematics(RobotScheme(), skeleton), markers);
  const auto largest_turn = [](const core::JointMatrix& angles) {
    return (angles.bottomRows(399) - angles.topRows(399)).rightCols(15).cwiseAbs().maxCoeff();
  };
  CHECK(LargestError(solved) > 0.02);
  CHECK(largest_turn(solved.motion.angles) < 3 * largest_turn(motion.angles));
}

TEST_CASE("SolveInverseKinematics: poorly determined angles stay calm", "[core][kinematics]") {
  // With nearly straight legs and marker noise of 1 mm, the twist of the thighs is poorly
  // determined.
  const auto skeleton = RobotLegs();
  JointMotion motion = Swing(skeleton, 200);
  for (const char* knee : {"lknee", "rknee", "lankle", "rankle"}) {
    motion.angles.col(skeleton->first_dof(skeleton->FindJoint(knee))).setConstant(0.02);
  }
  MarkerMotion markers = MarkersOf(RobotScheme(), motion);
  std::mt19937 random(8);
  std::normal_distribution<float> noise(0, 1e-3F);
  for (float& value : markers.positions_m.reshaped()) value += noise(random);
  const MarkerKinematics kinematics = Kinematics(RobotScheme(), skeleton);
  const auto roughness = [&](double smoothness) {
    const auto angles = Solve(kinematics, markers, {.smoothness = smoothness}).motion.angles;
    return (angles.bottomRows(198) - 2 * angles.middleRows(1, 198) + angles.topRows(198)).norm();
  };
  const double rough = roughness(0);
  CHECK(roughness(1e-4) < rough);
  CHECK(roughness(1e-2) < 0.5 * rough);
}

TEST_CASE("SolveInverseKinematics: refuses other markers and invalid options, and can be cancelled",
          "[core][kinematics]") {
  const auto skeleton = Figure();
  const MarkerMotion markers = MarkersOf(FigureScheme(), Swing(skeleton, 5));
  const MarkerKinematics kinematics = Kinematics(FigureScheme(), skeleton);
  const auto code = [&](const MarkerMotion& bad) {
    return core::SolveInverseKinematics(kinematics, bad).status().code();
  };
  MarkerMotion bad = markers;
  std::swap(bad.names[0], bad.names[1]);
  CHECK(code(bad) == absl::StatusCode::kInvalidArgument);
  bad = markers;
  bad.positions_m.conservativeResize(5, 6);
  CHECK(code(bad) == absl::StatusCode::kInvalidArgument);
  bad = markers;
  bad.positions_m(3, 4) = std::numeric_limits<float>::infinity();
  CHECK(code(bad) == absl::StatusCode::kInvalidArgument);
  bad = markers;
  bad.positions_m.setConstant(std::numeric_limits<float>::quiet_NaN());
  CHECK(code(bad) == absl::StatusCode::kInvalidArgument);
  const auto option_code = [&](const core::IkOptions& options) {
    return core::SolveInverseKinematics(kinematics, markers, options).status().code();
  };
  CHECK(option_code({.marker_weights = {1, 2}}) == absl::StatusCode::kInvalidArgument);
  const auto all = kinematics.marker_names().size();
  CHECK(option_code({.marker_weights = std::vector<double>(all, 0)}) ==
        absl::StatusCode::kInvalidArgument);
  CHECK(option_code({.marker_weights = std::vector<double>(all, -1)}) ==
        absl::StatusCode::kInvalidArgument);
  CHECK(option_code({.smoothness = std::nan("")}) == absl::StatusCode::kInvalidArgument);
  int checks = 0;
  const auto cancelled =
      core::SolveInverseKinematics(kinematics, markers, {}, [&] { return ++checks == 3; });
  CHECK(cancelled.status().code() == absl::StatusCode::kCancelled);
}

}  // namespace motiondb::tests::inverse_kinematics_test
