// A file's unit and up axis against the world's: metres, z up. Who decides, in this order: the
// caller, the file, the motion itself, custom.
#pragma once

#include <Eigen/Core>
#include <numbers>
#include <optional>
#include <string_view>

#include "core/format/motion_file.h"
#include "core/motion/matrix.h"

namespace motiondb::core {

inline constexpr double kRadiansPerDegree = std::numbers::pi / 180;

// What is known about a unit or an axis, and what custom has it to be where nothing is.
template <typename T>
struct Evidence {
  std::optional<T> given;
  std::optional<T> stated;
  std::optional<T> deduced;
  T custom;
};

// Write the value that the best evidence has, and its provenance, into the report.
void DecideUnit(const Evidence<double>& metres_per_unit, SourceReport& report);
void DecideUpAxis(const Evidence<UpAxis>& up, SourceReport& report);

// Metres per unit of a name such as "mm" or "meters", in any case; nothing if unknown.
std::optional<double> MetresPerUnitNamed(std::string_view name);

// The rotation that takes the file's up axis to the world's z.
Eigen::Matrix3d WorldFromFile(UpAxis up);

// From the file's unit and axes to the world's, as the report has them. positions: frames x 3 N.
void ToWorld(const SourceReport& report, FrameMatrix& positions);

}  // namespace motiondb::core
