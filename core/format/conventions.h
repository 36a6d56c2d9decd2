// A file's unit and up axis against the world's: metres, z up. Who decides, in this order: the
// caller, the file, the motion itself, custom.
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

// A frame rate (Hz) that motion can have: 0.001 to 100000.
bool IsFrameRate(double rate_hz);

// The whole rate, or the broadcast rate (23.976, 29.97, 59.94, 119.88), closest to `rate_hz` if it
// is within 0.1 percent of it, with a note if it differs; otherwise rate_hz.
double SnapFrameRate(double rate_hz, std::vector<std::string>& notes);

// Heads and feet, known by the names of joints or markers, tell a file's up axis and unit where the
// file does not. The functions keep no state and are safe to call from any thread.

// The axis along which heads are above feet, over frames spread across the clip. Points are known
// by their names ("Head", "LFHD", "LeftToeBase", "RANK"). Nothing if names do not tell heads and
// feet, or if no axis stands out. positions: frames x 3 * names.size(), in the file's axes and any
// unit.
std::optional<UpAxis> DeduceUpAxis(std::span<const std::string> names,
                                   const FrameMatrix& positions);

// Stature in the file's unit: the way along the bones from a foot up to the head, which does not
// depend on the pose. positions: frames x 3 * joints. Nothing if names do not tell head and feet.
std::optional<double> StatureAlongBones(const Skeleton& skeleton, const FrameMatrix& positions);

// Stature in the file's unit from bare points: the distance between head and feet.
std::optional<double> StatureOfPoints(std::span<const std::string> names,
                                      const FrameMatrix& positions);

// Of m, cm, mm, inch and CMU's 1/0.45 inch, the unit that makes the stature closest to a person's.
// Nothing if none makes it plausible.
std::optional<double> DeduceMetresPerUnit(double stature);

}  // namespace motiondb::core
