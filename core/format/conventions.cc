#include "core/format/conventions.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/format/text_scanner.h"

namespace motiondb::core {

namespace {

template <typename T>
void Decide(const ConventionSources<T>& evidence, T& value, Provenance& provenance) {
  if (evidence.given) {
    value = *evidence.given;
    provenance = Provenance::kGiven;
  } else if (evidence.stated) {
    value = *evidence.stated;
    provenance = Provenance::kStated;
  } else if (evidence.deduced) {
    value = *evidence.deduced;
    provenance = Provenance::kDeduced;
  } else {
    value = evidence.fallback;
    provenance = Provenance::kAssumed;
  }
}

}  // namespace

void DecideUnit(const ConventionSources<double>& metres_per_unit, SourceReport& report) {
  Decide(metres_per_unit, report.metres_per_unit, report.unit_provenance);
}

void DecideUpAxis(const ConventionSources<UpAxis>& up, SourceReport& report) {
  Decide(up, report.up_axis, report.up_provenance);
}

std::optional<double> MetresPerUnitNamed(std::string_view name) {
  struct Unit {
    std::string_view name;
    double metres;
  };
  constexpr std::array<Unit, 14> kUnits = {{{"m", 1},
                                            {"meter", 1},
                                            {"meters", 1},
                                            {"metre", 1},
                                            {"metres", 1},
                                            {"cm", 0.01},
                                            {"centimeters", 0.01},
                                            {"centimetres", 0.01},
                                            {"mm", 0.001},
                                            {"millimeters", 0.001},
                                            {"millimetres", 0.001},
                                            {"in", 0.0254},
                                            {"inch", 0.0254},
                                            {"inches", 0.0254}}};
  for (const Unit& unit : kUnits) {
    if (IsKeyword(name, unit.name)) return unit.metres;
  }
  return std::nullopt;
}

Eigen::Matrix3d WorldFromFile(UpAxis up) {
  Eigen::Matrix3d rotation;
  switch (up) {
    case UpAxis::kX:
      rotation << 0, 0, -1, 0, 1, 0, 1, 0, 0;
      break;
    case UpAxis::kY:
      rotation << 1, 0, 0, 0, 0, -1, 0, 1, 0;
      break;
    case UpAxis::kZ:
      rotation.setIdentity();
      break;
    case UpAxis::kMinusX:
      rotation << 0, 0, 1, 0, 1, 0, -1, 0, 0;
      break;
    case UpAxis::kMinusY:
      rotation << 1, 0, 0, 0, 0, 1, 0, -1, 0;
      break;
    case UpAxis::kMinusZ:
      rotation << 1, 0, 0, 0, -1, 0, 0, 0, -1;
      break;
  }
  return rotation;
}

void ToWorld(const SourceReport& report, FrameMatrix& positions) {
  const Eigen::Matrix3f world_from_file =
      (WorldFromFile(report.up_axis) * report.metres_per_unit).cast<float>();
  // One row for each point.
  Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>> points(
      positions.data(), positions.size() / 3, 3);
  points *= world_from_file.transpose();
}

bool IsFrameRate(double rate_hz) { return rate_hz >= 1e-3 && rate_hz <= 1e5; }

double SnapFrameRate(double rate_hz, std::vector<std::string>& notes) {
  constexpr double kClose = 1e-3;
  constexpr double kMinNotedDifference = 1e-6;
  constexpr std::array<double, 4> kBroadcast = {24000.0 / 1001, 30000.0 / 1001, 60000.0 / 1001,
                                                120000.0 / 1001};
  double nearest = std::round(rate_hz);
  for (const double rate : kBroadcast) {
    if (std::abs(rate - rate_hz) < std::abs(nearest - rate_hz)) nearest = rate;
  }
  const double difference = std::abs(nearest - rate_hz) / rate_hz;
  if (nearest <= 0 || difference > kClose) return rate_hz;
  if (difference > kMinNotedDifference) {
    notes.push_back(fmt::format("frame rate {:.8g} Hz taken for {:.8g} Hz", rate_hz, nearest));
  }
  return nearest;
}

}  // namespace motiondb::core
