// What a person says on the command line of `motiondb plan`, and the request that it makes.
#pragma once

#include <motiondb/messages.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace motiondb::client {

struct PlanRequestOptions {
  std::string database;
  std::string goal;         // X,Y,HEADING
  std::string start;        // CLIP@SECONDS
  std::string observation;  // a motion file
  std::string observation_skeleton;
  std::string tolerance;  // METRES,RADIANS
  double max_duration_seconds = 30;
  double search_seconds = 5;
  int layer = 0;
  std::vector<std::string> labels;
  std::vector<std::string> discs;     // X,Y,RADIUS
  std::vector<std::string> polygons;  // X,Y,X,Y,X,Y,...
  std::optional<double> clearance_m;
  std::uint32_t seed = 0;
  int alternatives = 0;
  std::string skeleton;  // a stored skeleton's name, or a URDF file
  bool ignore_joint_limits = false;
  double frame_rate_hz = 0;
  std::string method = "segments";
};

// Binds them to a command.
void AddPlanRequestOptions(CLI::App& command, PlanRequestOptions& options);

// Whether --skeleton names a file of a robot.
bool PlansForRobot(const PlanRequestOptions& options);

// Reads the files that the options name. Lists of numbers must have been checked, as the command
// line does.
absl::Status SetPlanRequest(const PlanRequestOptions& options, v1::PlanRequest& request);

// The numbers between the commas; nothing unless all are finite numbers.
std::optional<std::vector<double>> ParseNumbers(const std::string& text);

// Checks an option's value: `fits` says whether the numbers are right, `expected` what they should
// be.
CLI::Validator NumberList(const char* expected, bool (*fits)(const std::vector<double>&));

}  // namespace motiondb::client
