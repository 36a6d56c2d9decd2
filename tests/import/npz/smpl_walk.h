// A synthetic walk of the SMPL body models, as the arrays of archives.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "import/npz/smpl_body.h"

namespace motiondb::tests {

using NpzArrays = std::map<std::string, std::string>;  // name and .npy member

// Returns the archive of these arrays, compressed.
std::string NpzOf(const NpzArrays& arrays);

// Returns the rotation of an axis-angle vector by Rodrigues' formula.
Eigen::Matrix3d Rodrigues(const Eigen::Vector3d& v);

inline constexpr int kGaitFrames = 120;
inline constexpr double kGaitRate_hz = 60;

// A person of 1.75 m who walks straight ahead in the file's world, whose up axis is z or y.
struct Gait {
  std::vector<double> poses;  // kGaitFrames x 3 joints, axis-angle, rad
  std::vector<double> trans;  // kGaitFrames x 3, m
};
// `heading`: about the up axis, rad.
Gait SmplWalk(importer::SmplModel model, bool z_up, double heading = 0.6);

// Number of a model's pose parameters.
std::size_t PoseColumns(importer::SmplModel model);

// Returns a walk with z up as the arrays of an AMASS archive.
NpzArrays AmassWalk(importer::SmplModel model, const std::string& gender = "male");

}  // namespace motiondb::tests
