#include "client/cli/plan_request.h"

#include <fmt/format.h>
#include <motiondb/v1/plan.pb.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <string_view>

#include "client/cli/command.h"
#include "client/cli/motion_file.h"
#include "client/cli/query/query_options.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {

namespace {

using Numbers = std::vector<double>;

// Indices of angles, which can be in degrees.
constexpr std::size_t kHeadingOfGoal = 2;
constexpr std::size_t kAngleOfTolerance = 1;

bool IsPose(const Numbers& numbers) { return numbers.size() == 3; }
bool IsTolerance(const Numbers& numbers) {
  return numbers.size() == 2 && numbers[0] >= 0 && numbers[1] >= 0;
}
bool IsDisc(const Numbers& numbers) { return numbers.size() == 3 && numbers[2] > 0; }
bool IsPolygon(const Numbers& numbers) { return numbers.size() >= 6 && numbers.size() % 2 == 0; }

// A time in a clip: "CLIP@SECONDS".
struct Moment {
  std::string clip;
  double seconds = 0;
};

std::optional<Moment> ParseMoment(const std::string& text) {
  const size_t at = text.rfind('@');
  if (at == 0 || at == std::string::npos) return std::nullopt;
  const auto seconds = ParseNumbers(text.substr(at + 1));
  if (!seconds || seconds->size() != 1 || seconds->front() < 0) return std::nullopt;
  return Moment{text.substr(0, at), seconds->front()};
}

CLI::Validator ClipMomentText() {
  return CLI::Validator(
      [](const std::string& text) {
        return ParseMoment(text) ? "" : fmt::format("expected CLIP@SECONDS, got {}", text);
      },
      "");
}

void AddStartOptions(CLI::App& command, PlanRequestOptions& options) {
  CLI::Option* start = command.add_option("--start", options.start,
                                          "Start at a time of a stored clip; else standing");
  start->type_name("CLIP@SECONDS")->check(ClipMomentText());
  CLI::Option* observation = command.add_option("--observation", options.observation,
                                                "Start where the motion in this file ends");
  observation->type_name("FILE")->excludes(start);
  command
      .add_option("--observation-skeleton", options.observation_skeleton,
                  "ASF skeleton of an AMC observation; else the ASF in its folder")
      ->type_name("FILE.asf")
      ->needs(observation);
}

void AddGoalOptions(CLI::App& command, PlanRequestOptions& options) {
  command
      .add_option("--goal", options.goal,
                  "Goal relative to the start: metres to the front and to the left, and the angle "
                  "counter-clockwise in radians, or in degrees as in 30deg")
      ->type_name("X,Y,HEADING")
      ->required()
      ->check(NumberList("X,Y,HEADING, three numbers", IsPose, kHeadingOfGoal));
  command.add_flag("--force", options.force,
                   "Accept a heading beyond a full turn, which is usually in degrees");
  command
      .add_option("--tolerance", options.tolerance,
                  "Tolerances of goal position and heading, in radians or as in 5deg; else 0.1,0.1")
      ->type_name("METRES,ANGLE")
      ->check(
          NumberList("METRES,ANGLE, two numbers of at least 0", IsTolerance, kAngleOfTolerance));
  command
      .add_option("--max-duration", options.max_duration_seconds, "Maximum duration of the motion")
      ->type_name("SECONDS")
      ->check(PositiveNumber())
      ->capture_default_str();
  command.add_option("--search-seconds", options.search_seconds, "Time limit of the search")
      ->type_name("SECONDS")
      ->check(PositiveNumber())
      ->capture_default_str();
}

void AddFloorOptions(CLI::App& command, PlanRequestOptions& options) {
  command.add_option("--disc", options.discs, "Round obstacle; may be repeated")
      ->type_name("X,Y,RADIUS")
      ->allow_extra_args(false)
      ->check(NumberList("X,Y,RADIUS, three numbers, a radius greater than 0", IsDisc));
  command.add_option("--polygon", options.polygons, "Polygonal obstacle; may be repeated")
      ->type_name("X,Y,X,Y,X,Y,...")
      ->allow_extra_args(false)
      ->check(NumberList("the X,Y of at least three corners", IsPolygon));
  command
      .add_option("--clearance", options.clearance_m,
                  "Minimum distance of the root from obstacles; else 0.3")
      ->type_name("METRES")
      ->check(NonNegativeNumber());
}

void AddBodyOptions(CLI::App& command, PlanRequestOptions& options) {
  command
      .add_option(
          "--skeleton", options.skeleton,
          "Body of the motion: a skeleton of the database, or a robot; else the skeleton of "
          "the start clip")
      ->type_name("NAME|FILE.urdf");
  command.add_flag("--ignore-joint-limits", options.ignore_joint_limits,
                   "Allow joint positions and speeds beyond the limits of the robot");
  command
      .add_option(
          "--speed-limit-scale", options.speed_limit_scale,
          "Fraction of the robot's limits of joint speed to use; the motion is slowed where "
          "a joint would be faster")
      ->type_name("0..1")
      ->check(PositiveNumber())
      ->capture_default_str();
  command
      .add_option(
          "--max-joint-acceleration", options.max_joint_acceleration,
          "Maximum acceleration of each joint, for which the motion is slowed; else no limit")
      ->type_name("RAD/S^2")
      ->check(PositiveNumber());
  command
      .add_option("--frame-rate", options.frame_rate_hz,
                  "Frame rate of the motion; else the database's")
      ->type_name("HZ")
      ->check(PositiveNumber());
}

void AddSearchOptions(CLI::App& command, PlanRequestOptions& options) {
  command
      .add_option("--layer", options.layer,
                  "Layer of the coarse search, from 1; else about four fifths of the depth")
      ->type_name("N")
      ->check(PositiveNumber());
  command.add_option("--label", options.labels, "Use only clips with this label; may be repeated")
      ->type_name("L")
      ->allow_extra_args(false);
  AddSelectionOptions(command, options.filter, options.min_revision);
  command.add_option("--seed", options.seed, "Random seed; equal seeds give equal plans")
      ->type_name("N")
      ->capture_default_str();
  command.add_option("--alternatives", options.alternatives, "Number of alternative plans")
      ->type_name("N")
      ->check(CLI::Range(0, 10))
      ->capture_default_str();
  command
      .add_option("--method", options.method,
                  "Search method: stored segments, or the paper's random sampling")
      ->type_name("segments|random")
      ->check(CLI::IsMember({"segments", "random"}))
      ->capture_default_str();
}

absl::Status SetStart(const PlanRequestOptions& options, v1::PlanRequest& request) {
  if (!options.observation.empty()) {
    SourceOptions source;
    source.skeleton = options.observation_skeleton;
    auto observation = ObservationFromFile(options.observation, source);
    if (!observation.ok()) return observation.status();
    *request.mutable_observation_start() = *std::move(observation);
  } else if (const auto moment = ParseMoment(options.start)) {
    request.mutable_clip_start()->set_clip(ClipName(options.database, moment->clip));
    request.mutable_clip_start()->set_seconds(moment->seconds);
  }
  return absl::OkStatus();
}

void SetObstacles(const PlanRequestOptions& options, v1::PlanRequest& request) {
  if (options.discs.empty() && options.polygons.empty() && !options.clearance_m) return;
  v1::Obstacles& obstacles = *request.mutable_obstacles();
  if (options.clearance_m) obstacles.set_clearance_m(*options.clearance_m);
  for (const std::string& text : options.discs) {
    const Numbers numbers = *ParseNumbers(text);
    v1::Disc& disc = *obstacles.add_discs();
    disc.mutable_centre()->set_x_m(numbers[0]);
    disc.mutable_centre()->set_y_m(numbers[1]);
    disc.set_radius_m(numbers[2]);
  }
  for (const std::string& text : options.polygons) {
    const Numbers numbers = *ParseNumbers(text);
    v1::Polygon& polygon = *obstacles.add_polygons();
    for (size_t i = 0; i + 1 < numbers.size(); i += 2) {
      v1::FloorPoint& corner = *polygon.add_corners();
      corner.set_x_m(numbers[i]);
      corner.set_y_m(numbers[i + 1]);
    }
  }
}

absl::Status SetBody(const PlanRequestOptions& options, v1::PlanRequest& request) {
  if (PlansForRobot(options)) {
    auto urdf = ReadFileBytes(options.skeleton);
    if (!urdf.ok()) return urdf.status();
    v1::RobotDescription& robot = *request.mutable_robot();
    robot.set_file_name(std::filesystem::path(options.skeleton).filename().string());
    robot.set_urdf(*std::move(urdf));
  } else if (!options.skeleton.empty()) {
    request.set_skeleton(SkeletonName(options.database, options.skeleton));
  }
  return absl::OkStatus();
}

}  // namespace

void AddPlanRequestOptions(CLI::App& command, PlanRequestOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  AddGoalOptions(command, options);
  AddStartOptions(command, options);
  AddFloorOptions(command, options);
  AddBodyOptions(command, options);
  AddSearchOptions(command, options);
}

bool PlansForRobot(const PlanRequestOptions& options) {
  return MotionExtension(options.skeleton) == ".urdf";
}

absl::Status SetPlanRequest(const PlanRequestOptions& options, v1::PlanRequest& request) {
  request.set_database(DatabaseName(options.database));
  const Numbers goal = *ParseNumbers(options.goal, kHeadingOfGoal);
  request.mutable_goal()->set_x_m(goal[0]);
  request.mutable_goal()->set_y_m(goal[1]);
  request.mutable_goal()->set_heading_rad(
      options.force ? std::remainder(goal[2], 2 * std::numbers::pi) : goal[2]);
  if (!options.tolerance.empty()) {
    const Numbers tolerance = *ParseNumbers(options.tolerance, kAngleOfTolerance);
    request.set_position_tolerance_m(tolerance[0]);
    request.set_heading_tolerance_rad(tolerance[1]);
  }
  request.set_max_duration_seconds(options.max_duration_seconds);
  const auto search = std::llround(1e9 * options.search_seconds);
  request.mutable_search_timeout()->set_seconds(search / 1'000'000'000);
  request.mutable_search_timeout()->set_nanos(static_cast<int>(search % 1'000'000'000));
  if (options.layer != 0) request.set_coarse_layer(options.layer);
  for (const std::string& label : options.labels) request.add_labels(label);
  request.set_filter(options.filter);
  request.set_min_revision(options.min_revision);
  request.set_seed(options.seed);
  request.set_alternative_count(options.alternatives);
  request.set_ignore_joint_limits(options.ignore_joint_limits);
  if (options.speed_limit_scale != 1) request.set_speed_limit_scale(options.speed_limit_scale);
  if (options.max_joint_acceleration != 0) {
    request.set_max_joint_acceleration(options.max_joint_acceleration);
  }
  if (options.frame_rate_hz != 0) request.set_frame_rate_hz(options.frame_rate_hz);
  request.set_method(options.method == "random" ? v1::PLAN_METHOD_RANDOM_SAMPLING
                                                : v1::PLAN_METHOD_SEGMENT_SEARCH);
  SetObstacles(options, request);
  if (absl::Status status = SetStart(options, request); !status.ok()) return status;
  return SetBody(options, request);
}

std::optional<std::vector<double>> ParseNumbers(const std::string& text, std::size_t angle) {
  std::vector<double> numbers;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t comma = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, comma - begin);
    char* end = nullptr;
    double number = std::strtod(part.c_str(), &end);
    std::string_view unit = end;
    if (numbers.size() == angle && unit == "deg") number *= std::numbers::pi / 180;
    if (numbers.size() == angle && (unit == "deg" || unit == "rad")) unit = "";
    if (end == part.c_str() || !unit.empty() || !std::isfinite(number)) return std::nullopt;
    numbers.push_back(number);
    begin = comma + 1;
  }
  return numbers;
}

CLI::Validator NumberList(const char* expected, bool (*fits)(const std::vector<double>&),
                          std::size_t angle) {
  return CLI::Validator(
      [expected, fits, angle](const std::string& text) {
        const auto numbers = ParseNumbers(text, angle);
        return numbers && fits(*numbers) ? "" : fmt::format("expected {}, got {}", expected, text);
      },
      "");
}

}  // namespace motiondb::client
