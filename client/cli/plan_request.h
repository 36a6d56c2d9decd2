// Options of `motiondb plan`, and their conversion to a request.
#pragma once

#include <motiondb/messages.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace motiondb::client {

struct PlanRequestOptions {
  std::string database;
  std::string goal;         // X,Y,HEADING
  bool force = false;       // accept any heading
  std::string start;        // CLIP@SECONDS
  std::string observation;  // a motion file
  std::string observation_skeleton;
  std::string tolerance;  // METRES,ANGLE
  double max_duration_seconds = 30;
  double search_seconds = 5;
  int layer = 0;
  std::vector<std::string> labels;
  std::string filter;
  std::int64_t min_revision = 0;
  std::vector<std::string> discs;     // X,Y,RADIUS
  std::vector<std::string> polygons;  // X,Y,X,Y,X,Y,...
  std::optional<double> clearance_m;
  std::uint32_t seed = 0;
  int alternatives = 0;
  std::string skeleton;  // a stored skeleton's name, or a URDF file
  bool ignore_joint_limits = false;
  double speed_limit_scale = 1;
  double max_joint_acceleration = 0;  // 0: no limit
  double frame_rate_hz = 0;
  std::string method = "segments";
};

// Binds the options to a command.
void AddPlanRequestOptions(CLI::App& command, PlanRequestOptions& options);

// Returns whether --skeleton names a robot file.
bool PlansForRobot(const PlanRequestOptions& options);

// Converts the options to a request and reads their files. REQUIRES: lists of numbers are valid.
absl::Status SetPlanRequest(const PlanRequestOptions& options, v1::PlanRequest& request);

inline constexpr std::size_t kNoAngle = static_cast<std::size_t>(-1);

// Parses numbers separated by commas; nullopt unless all are finite. The number with the index
// `angle` may end with its unit, "rad" or "deg"; the result is in radians.
std::optional<std::vector<double>> ParseNumbers(const std::string& text,
                                                std::size_t angle = kNoAngle);

// Returns a validator of a list of numbers, with `angle` as above. `fits` checks the numbers;
// `expected` describes them.
CLI::Validator NumberList(const char* expected, bool (*fits)(const std::vector<double>&),
                          std::size_t angle = kNoAngle);

}  // namespace motiondb::client
