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
#include "core/motion/motion.h"

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

// Estimates of a file's unit and up axis from the figure of the person in it.
struct DeducedConventions {
  // In the file's unit: along the bones from a foot to the head, so independent of the pose, or for
  // markers the distance of head and feet. Nothing if there is no figure of a person.
  std::optional<double> stature;
  // m, cm, mm, inch or CMU's 1/0.45 inch, in metres: the one for which the stature is closest to a
  // person's. Nothing if none is plausible.
  std::optional<double> metres_per_unit;
  // The axis along which head or shoulders are above the feet in most frames. Nothing if no axis
  // dominates.
  std::optional<UpAxis> up_axis;
};

// Heads and feet are recognised by their names ("Head", "LFHD", "LeftToeBase", "RANK"), otherwise
// by the figure (core/mapping/figure.h). positions: frames x 3 * names.size(), in the file's axes,
// any unit. `skeleton`: of the names, null for markers. O(frames + points) and the search for the
// figure.
DeducedConventions DeduceConventions(std::span<const std::string> names,
                                     const FrameMatrix& positions,
                                     const Skeleton* skeleton = nullptr);

// Decides the unit of a file. A file without a known unit gets the unit that gives its figure the
// stature of a person, or without a figure the `usual` one of its format; a note says so.
void DecideUnit(std::optional<double> given, std::optional<double> stated,
                const DeducedConventions& deduced, double usual, SourceReport& report);

}  // namespace motiondb::core
