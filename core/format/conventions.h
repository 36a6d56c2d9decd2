// Conversion of a file's unit and up axis to the world's: metres, z up. Sources of the decision, by
// priority: the caller, the file, the motion itself, the format's default.
#pragma once

#include <Eigen/Core>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/format/motion_file.h"
#include "core/motion/matrix.h"

namespace motiondb::core {

inline constexpr double kRadiansPerDegree = std::numbers::pi / 180;

// The known values of a unit or an axis, and the default.
template <typename T>
struct ConventionSources {
  std::optional<T> given;
  std::optional<T> stated;
  std::optional<T> deduced;
  T fallback;
};

// Write the value with the highest priority and its provenance to the report.
void DecideUnit(const ConventionSources<double>& metres_per_unit, SourceReport& report);
void DecideUpAxis(const ConventionSources<UpAxis>& up, SourceReport& report);

// Returns the metres per unit of a name such as "mm" or "meters", in any case; nothing if unknown.
std::optional<double> MetresPerUnitNamed(std::string_view name);

// Returns the rotation from the file's axes to the world's (z up).
Eigen::Matrix3d WorldFromFile(UpAxis up);

// Converts positions (frames x 3 N) from the file's unit and axes to the world's, as in the report.
void ToWorld(const SourceReport& report, FrameMatrix& positions);

// Whether the frame rate (Hz) is supported: 0.001 to 100000.
bool IsFrameRate(double rate_hz);

// Returns the nearest integer or broadcast rate (23.976, 29.97, 59.94, 119.88) if it is within 0.1
// percent of `rate_hz`, with a note if it differs; otherwise rate_hz.
double SnapFrameRate(double rate_hz, std::vector<std::string>& notes);

}  // namespace motiondb::core
