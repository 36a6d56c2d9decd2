#include "core/planning/foot_lock.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "core/planning/motion_quality.h"
#include "tests/core/planning/walking_figure.h"
#include "tests/support/real_data.h"
#include "tests/support/real_motion.h"

namespace motiondb::tests::foot_lock_test {
namespace {

struct Outcome {
  core::MotionQuality before;
  core::MotionQuality after;
};

float Distance(const core::FrameMatrix& positions, Eigen::Index t, int a, int b) {
  return (positions.row(t).segment<3>(3 * a) - positions.row(t).segment<3>(3 * b)).norm();
}

// Locks the feet and checks the invariants of every motion: segments and feet keep their length;
// all other markers move only vertically, by the same amount.
Outcome Lock(const core::Feet& feet, const core::ContactMatrix& contacts, double leg_length_m,
             core::MarkerMotion& motion) {
  const core::FrameMatrix old = motion.positions_m;
  Outcome outcome;
  outcome.before = core::MeasureQuality(feet, motion, contacts, leg_length_m, nullptr);
  core::FrameMatrix& positions = motion.positions_m;
  core::LockFeet(feet, contacts, motion.frame_rate_hz, leg_length_m, positions);
  outcome.after = core::MeasureQuality(feet, motion, contacts, leg_length_m, nullptr);

  REQUIRE(positions.allFinite());
  float longest_change = 0;
  float others_aside = 0;
  float others_apart = 0;
  std::vector<bool> of_leg(motion.names.size());
  for (const core::Foot& foot : feet) {
    for (const auto* markers : {&foot.foot_markers, &foot.thigh_markers, &foot.shin_markers}) {
      for (const int m : *markers) of_leg[m] = true;
    }
    of_leg[foot.leg[1]] = true;
  }
  for (Eigen::Index t = 0; t < positions.rows(); ++t) {
    for (const core::Foot& foot : feet) {
      const auto [hip, knee, ankle] = foot.leg;
      const auto same = [&](int a, int b) {
        longest_change = std::max(longest_change,
                                  std::abs(Distance(positions, t, a, b) - Distance(old, t, a, b)));
      };
      same(hip, knee);
      same(knee, ankle);
      for (const int m : foot.thigh_markers) (same(hip, m), same(knee, m));
      for (const int m : foot.shin_markers) (same(knee, m), same(ankle, m));
      for (const int m : foot.foot_markers) {
        for (const int n : foot.foot_markers) same(m, n);
      }
    }
    const Eigen::RowVectorXf moved = positions.row(t) - old.row(t);
    const float raised = moved[3 * feet[0].leg[0] + 2];
    for (std::size_t m = 0; m < of_leg.size(); ++m) {
      if (of_leg[m]) continue;
      const auto at = 3 * static_cast<Eigen::Index>(m);
      others_aside = std::max(others_aside, moved.segment<2>(at).norm());
      others_apart = std::max(others_apart, std::abs(moved[at + 2] - raised));
    }
  }
  CHECK(longest_change < 1e-4);
  CHECK(others_aside == 0);
  CHECK(others_apart < 1e-5);
  return outcome;
}

// The walker's feet and true contacts, with all positions multiplied by `stretch` and a sideways
// drift.
Outcome LockWalker(const WalkingFigure& figure, float stretch, float drift_m_s) {
  const core::Feet feet = core::FindFeet(WalkingFigure{}.Model());
  core::MarkerMotion motion = figure.Motion();
  for (Eigen::Index t = 0; t < motion.positions_m.rows(); ++t) {
    const auto seconds = static_cast<float>(static_cast<double>(t) / figure.rate_hz);
    const float forth = (stretch - 1) * static_cast<float>(figure.speed_m_s) * seconds;
    for (Eigen::Index c = 0; c < motion.positions_m.cols(); c += 3) {
      motion.positions_m(t, c) += forth;
      motion.positions_m(t, c + 1) += drift_m_s * seconds;
    }
  }
  return Lock(feet, figure.Contacts(feet, motion.positions_m.rows()), WalkingFigure::kLeg_m,
              motion);
}

double Share(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

// Returns the root mean square of the markers' third differences in each frame, m/s^3.
std::vector<double> Jerks(const core::MarkerMotion& motion) {
  const core::FrameMatrix& p = motion.positions_m;
  std::vector<double> jerks;
  for (Eigen::Index t = 0; t + 3 < p.rows(); ++t) {
    jerks.push_back((p.row(t + 3) - 3 * p.row(t + 2) + 3 * p.row(t + 1) - p.row(t)).norm() *
                    std::pow(motion.frame_rate_hz, 3) /
                    std::sqrt(static_cast<double>(p.cols()) / 3));
  }
  return jerks;
}

}  // namespace

TEST_CASE("LockFeet: feet that do not slide hardly move", "[core][planning]") {
  const WalkingFigure figure;
  const core::Feet feet = core::FindFeet(figure.Model());
  core::MarkerMotion motion = figure.Motion();
  const core::FrameMatrix old = motion.positions_m;
  const Outcome outcome = Lock(feet, figure.Contacts(feet, old.rows()), figure.kLeg_m, motion);
  CHECK(outcome.before.foot_slide_cm_per_s < 0.1);
  CHECK(outcome.after.foot_slide_cm_per_s < 0.2);
  CHECK((motion.positions_m - old).cwiseAbs().maxCoeff() < 0.01);
}

TEST_CASE("LockFeet: sliding feet are locked, at any rate, without a jerk", "[core][planning]") {
  for (const double rate : {30.0, 60.0, 120.0}) {
    for (const float stretch : {0.95f, 1.05f}) {
      for (const float drift_m_s : {0.0f, 0.05f}) {
        INFO(rate << " Hz, stretched by " << stretch << ", drift " << drift_m_s);
        const Outcome outcome = LockWalker({.rate_hz = rate}, stretch, drift_m_s);
        CHECK(outcome.before.foot_slide_cm_per_s > 3);
        CHECK(outcome.after.foot_slide_cm_per_s < 0.25 * outcome.before.foot_slide_cm_per_s);
        CHECK(outcome.after.floor_penetration_cm < 0.01);
        CHECK(outcome.after.peak_marker_jerk_m_s3 < 1.3 * outcome.before.peak_marker_jerk_m_s3);
      }
    }
  }
}

TEST_CASE("LockFeet: feet below the floor are raised", "[core][planning]") {
  const Outcome outcome = LockWalker({.floor_m = -0.03}, 1, 0);
  CHECK(outcome.before.floor_penetration_cm > 2.5);
  CHECK(outcome.after.floor_penetration_cm < 0.01);
  CHECK(outcome.after.foot_slide_cm_per_s < 0.2);
}

TEST_CASE("LockFeet: a foot out of the leg's reach is released", "[core][planning]") {
  const core::Feet feet = core::FindFeet(WalkingFigure{}.Model());
  core::MarkerMotion motion = WalkingFigure{}.Motion();
  // The body walks, but both feet are marked as in contact all the time.
  Lock(feet, core::ContactMatrix::Constant(motion.positions_m.rows(), 4, true),
       WalkingFigure::kLeg_m, motion);
}

TEST_CASE("LockFeet: without feet, contacts or frames it changes nothing", "[core][planning]") {
  const core::Feet feet = core::FindFeet(WalkingFigure{}.Model());
  core::MarkerMotion motion = WalkingFigure{}.Motion();
  const core::FrameMatrix old = motion.positions_m;
  core::LockFeet({}, core::ContactMatrix(old.rows(), 0), 60, 1, motion.positions_m);
  CHECK(motion.positions_m == old);
  for (const Eigen::Index frames : {0, 1, 2}) {
    for (const bool stands : {false, true}) {
      core::FrameMatrix few = old.topRows(frames);
      core::LockFeet(feet, core::ContactMatrix::Constant(frames, 4, stands), 60,
                     WalkingFigure::kLeg_m, few);
      CHECK(few.allFinite());
    }
  }
}

TEST_CASE("LockFeet: recorded walking, original and with a stretched path",
          "[core][planning][data]") {
  MOTIONDB_REQUIRE_DATA();
  constexpr double kRate = 60;
  core::BuildSettings settings;
  settings.frame_rate_hz = kRate;
  settings.min_frames = 10000;  // a small tree is enough
  const core::Model model = BuildFromList(DataDir() / "sets" / "database2.tsv", settings);
  const core::Feet feet = core::FindFeet(model);
  for (const double stretch : {1.0, 0.95, 1.05}) {
    std::vector<double> source_slide;
    std::vector<double> stretched_slide;
    std::vector<double> slide;
    std::vector<double> penetration;
    std::vector<double> source_jerk;
    std::vector<double> jerk_ratio;
    for (const core::ModelClip& clip : model.clips()) {
      core::StateSequence states;
      states.frame_rate_hz = kRate;
      states.leg_length_m = clip.leg_length_m;
      states.states = model.states().middleRows(clip.first_frame, clip.frame_count);
      model.scale().Revert(states.states);
      states.root_path = model.root_path().middleRows(clip.first_frame, clip.frame_count);
      core::MarkerMotion motion{model.marker_set().markers, kRate, core::WorldPositions(states)};
      const core::ContactMatrix contacts =
          core::DetectContacts(feet, motion.positions_m, kRate, clip.leg_length_m);
      const core::MotionQuality source =
          core::MeasureQuality(feet, motion, contacts, clip.leg_length_m, nullptr);
      // Recordings have frames with a jump of a joint, which set the peak.
      source_jerk.push_back(source.peak_marker_jerk_m_s3);
      const double usual_jerk = Share(Jerks(motion), 0.98);
      states.root_path.leftCols<2>() *= stretch;
      motion.positions_m = core::WorldPositions(states);
      INFO(clip.id << " stretched by " << stretch);
      const Outcome outcome = Lock(feet, contacts, clip.leg_length_m, motion);
      source_slide.push_back(source.foot_slide_cm_per_s);
      stretched_slide.push_back(outcome.before.foot_slide_cm_per_s);
      slide.push_back(outcome.after.foot_slide_cm_per_s);
      penetration.push_back(outcome.before.floor_penetration_cm);
      jerk_ratio.push_back(Share(Jerks(motion), 0.98) / usual_jerk);
      CHECK(slide.back() < 0.4 * source.foot_slide_cm_per_s);
      CHECK(outcome.after.floor_penetration_cm < 0.05);
      CHECK(jerk_ratio.back() < 1.4);
      CHECK(outcome.after.peak_marker_jerk_m_s3 < 1.3 * source.peak_marker_jerk_m_s3);
    }
    const auto print = [](const char* what, const std::vector<double>& values) {
      std::printf("  %-42s median %8.2f  largest %8.2f\n", what, Share(values, 0.5),
                  Share(values, 1));
    };
    std::printf("database 2, paths stretched by %.2f:\n", stretch);
    print("slide of the source, cm/s", source_slide);
    print("slide when stretched, cm/s", stretched_slide);
    print("slide when locked, cm/s", slide);
    print("penetration of the source, cm", penetration);
    print("peak jerk of the source, m/s^3", source_jerk);
    print("98 % jerk, locked by source", jerk_ratio);
  }
}

}  // namespace motiondb::tests::foot_lock_test
