// Conversion of a file's unit and up axis to the world's: metres, z up. Sources of the decision, by
// priority: the caller, the file, the motion itself, the format's default.
#pragma once

#include <Eigen/Core>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/format/motion_file.h"
#include "core/motion/matrix.h"
#include "core/motion/skeleton.h"

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

// Estimates of a file's up axis and unit from heads and feet, recognised by name.

// Returns the axis along which heads are above feet, over frames spread across the clip. Points are
// recognised by name ("Head", "LFHD", "LeftToeBase", "RANK"). Nothing if there are no heads or
// feet, or if no axis dominates. positions: frames x 3 * names.size(), in the file's axes, any
// unit.
std::optional<UpAxis> DeduceUpAxis(std::span<const std::string> names,
                                   const FrameMatrix& positions);

// Returns the stature in the file's unit: the path length along the bones from a foot to the head,
// independent of the pose. positions: frames x 3 * joints. Nothing if names contain no head or
// foot.
std::optional<double> StatureAlongBones(const Skeleton& skeleton, const FrameMatrix& positions);

// Returns the stature in the file's unit from markers: the distance between head and feet.
std::optional<double> StatureOfPoints(std::span<const std::string> names,
                                      const FrameMatrix& positions);

// Returns the unit (m, cm, mm, inch or CMU's 1/0.45 inch, in metres) for which the stature is
// closest to a person's. Nothing if none is plausible.
std::optional<double> DeduceMetresPerUnit(double stature);

}  // namespace motiondb::core
