// Plans of robots to seeded random goals in database2, timed as recorded and within the joint
// limits: samples beyond a limit, goals reached, foot slide, duration, planning time. Limits are
// checked here from differences of the returned joint angles, as a user would.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/format/marker_set_file.h"
#include "core/format/urdf_reader.h"
#include "core/mapping/fit_scheme.h"
#include "core/model/model_builder.h"
#include "core/motion/error.h"
#include "core/planning/plan.h"
#include "tests/support/motion_source.h"
#include "tests/support/plan_goals.h"
#include "tests/support/real_data.h"

namespace motiondb::tests {
namespace {

constexpr double kTolerance = 1e-6;  // share of a limit

absl::StatusOr<core::Model> BuildWalks() {
  const core::BuildSettings settings;
  MOTIONDB_ASSIGN_OR_RETURN(const auto clips, ReadClipList(DataDir() / "sets" / "database2.tsv"));
  std::vector<core::BuildInput> inputs;
  for (const ListedClip& clip : clips) {
    MOTIONDB_ASSIGN_OR_RETURN(const core::MotionFile file, ReadMotion(clip.path));
    MOTIONDB_ASSIGN_OR_RETURN(
        const core::MarkerScheme scheme,
        core::FitScheme(core::StandardScheme(), file.motion, core::FitFor::kClip));
    MOTIONDB_ASSIGN_OR_RETURN(
        core::StateSequence states,
        core::Represent(scheme, file.motion, settings.frame_rate_hz, core::GlitchPolicy::kRepair));
    inputs.push_back({clip.path.stem().string(), clip.label, std::move(states)});
  }
  return core::BuildModel(settings, core::StandardScheme().set, std::move(inputs),
                          core::RunSerially, {});
}

struct Robot {
  std::string name;
  std::shared_ptr<const core::Skeleton> skeleton;
  std::shared_ptr<const core::RobotDynamics> dynamics;
};

// Sums over all goals.
struct Tally {
  int exact = 0;
  int beyond_position = 0;
  int beyond_speed = 0;
  int beyond_acceleration = 0;
  std::set<Eigen::Index> fast_joints;
  std::vector<double> slides_cm;  // of feet in contact, of each plan
  double slide_cm_per_s = 0;      // sum of the plans' own figures
  double duration_s = 0;
  double slowest = 1;  // largest factor of a slowed part
  std::vector<double> planning_ms;
  std::vector<double> effort_ratios;  // largest effort to its limit, of each plan
  std::vector<double> margins_cm;     // smallest, of the zero-moment point, of each plan
  double outside_s = 0;
  double supported_s = 0;
};

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

void CheckLimits(const Robot& robot, const core::JointMotion& motion, double max_acceleration,
                 Tally& tally) {
  const core::JointLimits limits = core::LimitsOf(*robot.skeleton);
  const core::JointMatrix& q = motion.angles;
  const double rate = motion.frame_rate_hz;
  const auto root = static_cast<Eigen::Index>(robot.skeleton->joints()[0].dofs.size());
  const auto above = [](double value, double limit) {
    return value > limit + kTolerance * std::abs(limit);
  };
  for (Eigen::Index c = root; c < q.cols(); ++c) {
    for (Eigen::Index t = 0; t < q.rows(); ++t) {
      tally.beyond_position += above(q(t, c), limits.upper[c]) || above(-q(t, c), -limits.lower[c]);
      if (t > 0 && above(rate * std::abs(q(t, c) - q(t - 1, c)), robot.dynamics->max_speeds[c])) {
        ++tally.beyond_speed;
        tally.fast_joints.insert(c);
      }
      tally.beyond_acceleration +=
          t > 1 &&
          above(rate * rate * std::abs(q(t, c) - 2 * q(t - 1, c) + q(t - 2, c)), max_acceleration);
    }
  }
}

void AddForces(const Robot& robot, const core::RobotForces& forces, Tally& tally) {
  double ratio = 0;
  for (const core::PeakEffort& peak : forces.efforts) {
    ratio = std::max(ratio, peak.effort / robot.dynamics->max_efforts[peak.coordinate]);
  }
  tally.effort_ratios.push_back(ratio);
  if (!forces.balance) return;
  tally.margins_cm.push_back(100 * forces.balance->smallest_margin_m);
  tally.outside_s += forces.balance->outside_seconds;
  tally.supported_s += forces.balance->supported_seconds;
}

void Plan(const core::Model& model, const Robot& robot, const core::PlanProblem& problem,
          double checked_acceleration, bool show_missing, Tally& tally) {
  const auto begin = std::chrono::steady_clock::now();
  const auto answer = core::PlanMotion(model, core::StandardScheme(), problem);
  tally.planning_ms.push_back(
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
  if (!answer.ok()) {
    std::printf("failed: %s\n", answer.status().ToString().c_str());
    return;
  }
  tally.exact += answer->outcome == core::PlanOutcome::kExact;
  if (show_missing && !answer->missing.empty()) {
    fmt::print("goal {:.2f},{:.2f},{:.2f}: {}\n", problem.goal.x, problem.goal.y,
               problem.goal.heading, answer->missing);
  }
  if (answer->motions.empty()) return;
  const core::PlannedMotion& motion = answer->motions.front();
  if (motion.forces) AddForces(robot, *motion.forces, tally);
  CheckLimits(robot, *motion.joints, checked_acceleration, tally);
  tally.duration_s += motion.quality.duration_seconds;
  double contact_s = 0;
  Eigen::Index column = 0;
  for (const core::Foot& foot : core::FindFeet(model)) {
    const auto markers = static_cast<Eigen::Index>(foot.contact_markers.size());
    const auto stands = motion.contacts.middleCols(column, markers);
    for (Eigen::Index t = 1; t < stands.rows(); ++t) {
      contact_s += (stands.row(t) && stands.row(t - 1)).any() / motion.joints->frame_rate_hz;
    }
    column += markers;
  }
  tally.slides_cm.push_back(contact_s * motion.quality.motion.foot_slide_cm_per_s);
  tally.slide_cm_per_s += motion.quality.motion.foot_slide_cm_per_s;
  for (const core::SlowedPart& part : motion.slowed) {
    tally.slowest = std::max(tally.slowest, part.factor);
  }
}

std::vector<Robot> ReadRobots() {
  std::vector<Robot> robots;
  for (const auto& entry : std::filesystem::directory_iterator(DataDir() / "robots")) {
    if (entry.path().extension() != ".urdf") continue;
    const std::string bytes = ReadFile(entry.path());
    const std::string name = entry.path().stem().string();
    auto robot = core::ReadUrdf({.name = name, .bytes = bytes});
    if (!robot.ok()) {
      std::printf("%s\n", robot.status().ToString().c_str());
      continue;
    }
    robots.push_back({name, std::make_shared<const core::Skeleton>(std::move(robot->skeleton)),
                      std::make_shared<const core::RobotDynamics>(std::move(robot->dynamics))});
  }
  std::sort(robots.begin(), robots.end(),
            [](const Robot& a, const Robot& b) { return a.name < b.name; });
  return robots;
}

void PrintRow(const char* timing, const Robot& robot, const Tally& tally, int goals,
              const Tally& recorded) {
  int slides_more = 0;
  for (std::size_t i = 0; i < std::min(tally.slides_cm.size(), recorded.slides_cm.size()); ++i) {
    slides_more += tally.slides_cm[i] > 1.01 * recorded.slides_cm[i];
  }
  fmt::print(
      "| {} | {} | {}/{} | {} | {} ({}) | {} | {:.2f} | {} | {:.2f} | {:.2f} | {:.2f} | {:.1f} | "
      "{:.2f} |\n",
      robot.name, timing, tally.exact, goals, tally.beyond_position, tally.beyond_speed,
      tally.fast_joints.size(), tally.beyond_acceleration, Mean(tally.slides_cm), slides_more,
      tally.slide_cm_per_s / goals, tally.duration_s / goals, tally.slowest,
      Mean(tally.planning_ms), Mean(tally.planning_ms) / Mean(recorded.planning_ms));
  std::fflush(stdout);
}

double Median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void PrintForces(const char* timing, const Robot& robot, const Tally& tally) {
  const auto beyond = std::count_if(tally.effort_ratios.begin(), tally.effort_ratios.end(),
                                    [](double ratio) { return ratio > 1; });
  std::printf("| %-21s | %-14s | %6.2f | %3td/%zu | %6.1f | %5.1f |\n", robot.name.c_str(), timing,
              Median(tally.effort_ratios), beyond, tally.effort_ratios.size(),
              Median(tally.margins_cm), 100 * tally.outside_s / tally.supported_s);
}

struct Options {
  int goals = 200;
  unsigned seed = 2026;
  double max_acceleration = 50;
  double frame_rate_hz = 60;  // of plans within limits
  std::string robot;          // empty: all
  bool show_missing = false;
};

int Run(const Options& options) {
  const int goal_count = options.goals;
  const double max_acceleration = options.max_acceleration;

  const auto built = BuildWalks();
  if (!built.ok()) {
    std::printf("%s\n", built.status().ToString().c_str());
    return 1;
  }
  const core::Model& model = *built;
  const auto goals = RandomGoals(goal_count, options.seed);
  std::printf("%d goals, seed %u, limit of acceleration %g rad/s^2, one thread\n\n", goal_count,
              options.seed, max_acceleration);
  std::printf(
      "| robot | timing | EXACT | beyond position | beyond speed (joints) | beyond acceleration | "
      "slide, cm | plans that slide more | slide, cm/s | duration, s | largest factor | planning, "
      "ms | ratio |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  std::vector<std::pair<Robot, std::array<Tally, 2>>> forces;
  for (const Robot& robot : ReadRobots()) {
    if (!options.robot.empty() && robot.name != options.robot) continue;
    Tally recorded;
    Tally speeds;
    Tally accelerations;
    for (const core::FloorPose& goal : goals) {
      core::PlanProblem problem{.goal = goal, .skeleton = robot.skeleton, .flat_soles = true};
      Plan(model, robot, problem, max_acceleration, options.show_missing, recorded);
      problem.dynamics = robot.dynamics;
      problem.frame_rate_hz = options.frame_rate_hz;
      Plan(model, robot, problem, max_acceleration, options.show_missing, speeds);
      problem.max_joint_acceleration = max_acceleration;
      Plan(model, robot, problem, max_acceleration, options.show_missing, accelerations);
    }
    PrintRow("recorded", robot, recorded, goal_count, recorded);
    PrintRow("speeds", robot, speeds, goal_count, recorded);
    PrintRow("+ acceleration", robot, accelerations, goal_count, recorded);
    forces.push_back({robot, {std::move(speeds), std::move(accelerations)}});
  }
  std::printf(
      "\n| robot | timing | largest effort / limit, median | plans beyond | smallest margin of the "
      "zero-moment point, cm, median | outside, %% of the supported time |\n"
      "|---|---|---|---|---|---|\n");
  for (const auto& [robot, tallies] : forces) {
    PrintForces("speeds", robot, tallies[0]);
    PrintForces("+ acceleration", robot, tallies[1]);
  }
  return 0;
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) {
  CLI::App app("Plans of robots within their joint limits");
  motiondb::tests::Options options;
  app.add_option("--goals", options.goals, "Number of goals for each robot")->capture_default_str();
  app.add_option("--seed", options.seed, "Seed of the goals")->capture_default_str();
  app.add_option("--max-joint-acceleration", options.max_acceleration, "rad/s^2")
      ->capture_default_str();
  app.add_option("--frame-rate", options.frame_rate_hz, "Of plans within limits, Hz")
      ->capture_default_str();
  app.add_option("--robot", options.robot, "Only this robot");
  app.add_flag("--show-missing", options.show_missing, "Print why goals are not EXACT");
  CLI11_PARSE(app, argc, argv);
  if (!std::filesystem::exists(motiondb::tests::DataDir() / "robots")) {
    std::printf("skipped: no robots in %s\n", motiondb::tests::DataDir().string().c_str());
    return 0;
  }
  return motiondb::tests::Run(options);
}
