#include "core/format/plausibility.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "core/format/conventions.h"
#include "core/motion/error.h"
#include "core/motion/samples.h"

namespace motiondb::core {
namespace {

constexpr double kUsualLeg_m = 0.85;
constexpr std::string_view kForce = "if it is right, set force (--force)";

struct Unit {
  std::string_view name;
  double metres;
};
constexpr std::array<Unit, 5> kUnits = {
    {{"m", 1}, {"cm", 0.01}, {"mm", 0.001}, {"inch", 0.0254}, {"CMU's unit", 0.0254 / 0.45}}};

bool IsPersonLeg(double leg_m) { return leg_m >= kMinPersonLeg_m && leg_m <= kMaxPersonLeg_m; }

// Returns the unit in which a length is closest to a person's leg.
std::optional<Unit> UnitOfLeg(double leg_units) {
  std::optional<Unit> best;
  double least = std::numeric_limits<double>::infinity();
  for (const Unit& unit : kUnits) {
    const double leg_m = leg_units * unit.metres;
    const double distance = std::abs(std::log(leg_m / kUsualLeg_m));
    if (!IsPersonLeg(leg_m) || distance >= least) continue;
    least = distance;
    best = unit;
  }
  return best;
}

// Returns the median length of the whole legs; nothing if no frame has a whole leg. `at(frame,
// marker)`: a position.
template <typename At>
std::optional<double> MedianLeg(const MarkerSet& set, int frame_count, const At& at) {
  constexpr int kSampledFrames = 200;
  const int step = std::max(1, frame_count / kSampledFrames);
  std::vector<double> lengths;
  for (int t = 0; t < frame_count; t += step) {
    for (const auto& [hip, knee, ankle] : set.landmarks.legs) {
      const double length = (at(t, hip) - at(t, knee)).norm() + (at(t, knee) - at(t, ankle)).norm();
      if (std::isfinite(length)) lengths.push_back(length);
    }
  }
  if (lengths.empty()) return std::nullopt;
  return Median(lengths);
}

absl::Status WithOption(const std::string& option, absl::Status status) {
  return option.empty() ? status : WithResource("option", option, std::move(status));
}

// The direction of a body from the feet to the neck, in the world: unit vectors of the trunk and of
// the legs.
struct Posture {
  Eigen::Vector3d trunk;
  Eigen::Vector3d legs;
};

std::optional<Posture> PostureAt(const MarkerSet& set, int pelvis, int neck,
                                 const StateSequence& states, int frame) {
  const auto at = [&](int marker) -> Eigen::Vector3d {
    return states.states.row(frame).segment<3>(6 * marker).transpose().cast<double>();
  };
  Eigen::Vector3d legs = Eigen::Vector3d::Zero();
  for (const auto& [hip, knee, ankle] : set.landmarks.legs) legs += at(hip) - at(ankle);
  const Eigen::Vector3d trunk = at(neck) - at(pelvis);
  if (!legs.allFinite() || !trunk.allFinite() || legs.isZero() || trunk.isZero()) {
    return std::nullopt;
  }
  const Eigen::AngleAxisd turn(states.root_path(frame, 2), Eigen::Vector3d::UnitZ());
  return Posture{turn * trunk.normalized(), turn * legs.normalized()};
}

std::string AxisName(const Eigen::Vector3d& direction) {
  int axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  return fmt::format("{}{}", direction[axis] < 0 ? "-" : "", "xyz"[axis]);
}

}  // namespace

absl::Status CheckFrameRate(double frame_rate_hz, double database_rate_hz) {
  const double lowest_hz = database_rate_hz / kMaxFramesPerSourceFrame;
  if (frame_rate_hz >= lowest_hz) return absl::OkStatus();
  return InvalidArgument(
      "expected a frame rate of at least {:g} Hz, 1/{:g} of the database's {:g} Hz, got {:g} Hz "
      "(Frame Time: {:g}): check its unit",
      lowest_hz, kMaxFramesPerSourceFrame, database_rate_hz, frame_rate_hz, 1 / frame_rate_hz);
}

absl::Status CheckGivenLegLength(double leg_length_m) {
  if (IsPersonLeg(leg_length_m)) return absl::OkStatus();
  auto unit = UnitOfLeg(leg_length_m);
  if (unit && unit->name == kUnits.back().name) unit.reset();  // only of files
  const std::string probably = unit ? fmt::format("{} {} are {:.4g} m", leg_length_m, unit->name,
                                                  leg_length_m * unit->metres)
                                    : std::string("check the number");
  return InvalidArgument("expected {} to {} m for a person, got {}; {}; {}", kMinPersonLeg_m,
                         kMaxPersonLeg_m, leg_length_m, probably, kForce);
}

absl::Status CheckBodySize(const MarkerSet& set, const StateSequence& states,
                           const SourceReport& report) {
  const auto leg = MedianLeg(set, states.frame_count(), [&](int frame, int marker) {
    return states.states.row(frame).segment<3>(6 * marker);
  });
  return leg ? CheckMeasuredLeg(*leg * states.leg_length_m, report) : absl::OkStatus();
}

absl::Status CheckBodySize(const MarkerSet& set, const MarkerMotion& motion,
                           const SourceReport& report) {
  const auto frames = static_cast<int>(motion.positions_m.rows());
  const auto leg_m = MedianLeg(set, frames, [&](int frame, int marker) {
    return motion.positions_m.row(frame).segment<3>(3 * marker);
  });
  return leg_m ? CheckMeasuredLeg(*leg_m, report) : absl::OkStatus();
}

absl::Status CheckMeasuredLeg(double leg_length_m, const SourceReport& report) {
  if (IsPersonLeg(leg_length_m)) return absl::OkStatus();
  const auto unit = UnitOfLeg(leg_length_m / report.metres_per_unit);
  std::string option;
  std::string probably = "check the unit";
  if (unit) {
    option = fmt::format("--metres-per-unit {:.4g}", unit->metres);
    probably = fmt::format("the unit is probably {}: set metres_per_unit {:.4g} ({})", unit->name,
                           unit->metres, option);
  }
  return WithOption(
      option,
      InvalidArgument(
          "the legs would be {:.3g} m long with {:.4g} m per unit; expected {} to {} m for a "
          "person; {}; {}",
          leg_length_m, report.metres_per_unit, kMinPersonLeg_m, kMaxPersonLeg_m, probably,
          kForce));
}

absl::Status CheckPosture(const MarkerSet& set, const StateSequence& states,
                          const SourceReport& report) {
  constexpr double kUpright = 0.5;  // sine of the angle between the floor and trunk or legs
  constexpr double kThroughout = 0.95;
  const int pelvis = set.FindMarker("Pelvis");
  const int neck = set.FindMarker("Neck");
  if (pelvis < 0 || neck < 0 || set.landmarks.legs.empty()) return absl::OkStatus();
  int known = 0;
  int lying = 0;
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (int t = 0; t < states.frame_count(); ++t) {
    const auto posture = PostureAt(set, pelvis, neck, states, t);
    if (!posture) continue;
    ++known;
    if (posture->trunk.z() >= kUpright || posture->legs.z() >= kUpright) continue;
    ++lying;
    up += posture->trunk + posture->legs;
  }
  if (known == 0 || lying < kThroughout * known) return absl::OkStatus();
  const std::string was = AxisName(WorldFromFile(report.up_axis).transpose().col(2));
  const std::string axis = AxisName(WorldFromFile(report.up_axis).transpose() * up);
  const bool has_direction = up.norm() > lying;  // of at most 2 * lying
  std::string option;
  std::string probably = "check the axes";
  if (has_direction && !axis.starts_with('-') && axis != was) {
    option = fmt::format("--up-axis {}", axis);
    probably = fmt::format("probably {0} points up: set up_axis {0} ({1})", axis, option);
  }
  return WithOption(
      option,
      InvalidArgument("the body lies throughout, its head along {} of the file, with {} up; {}; {}",
                      axis, was, probably, kForce));
}

}  // namespace motiondb::core
