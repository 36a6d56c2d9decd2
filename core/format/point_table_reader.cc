#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

#include "core/format/conventions.h"
#include "core/format/readers.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

constexpr double kSingleFrameRate_hz = 30;

struct PointColumns {
  std::vector<std::string> names;
  double metres_per_unit = 1;
};

// Reads NAME_x_m, NAME_y_m, NAME_z_m of each point; the unit of the first is the unit of all.
absl::StatusOr<PointColumns> PointsOfHeader(const CsvRows& rows,
                                            std::span<const std::string> header,
                                            std::vector<std::string>& notes) {
  PointColumns points;
  UniqueNames unique;
  std::string_view unit_name;
  for (std::size_t c = 1; c < header.size(); c += 3) {
    const std::string_view column = header[c];
    const std::size_t end = column.rfind("_x_");
    const std::string_view unit = end == column.npos ? "" : column.substr(end + 3);
    const auto metres = MetresPerUnitNamed(unit);
    if (!metres || end == 0 || (c > 1 && unit != unit_name)) {
      return rows.Error("expected column {} to be 'NAME_x_{}', found '{}'", c + 1,
                        c > 1 ? unit_name : "m", Shown(column));
    }
    const std::string_view name = column.substr(0, end);
    for (std::size_t axis = 1; axis < 3; ++axis) {
      const std::string expected = fmt::format("{}_{}_{}", name, "xyz"[axis], unit);
      if (c + axis < header.size() && header[c + axis] == expected) continue;
      return rows.Error("expected column {} to be '{}', found '{}'", c + axis + 1, Shown(expected),
                        c + axis < header.size() ? Shown(header[c + axis]) : "");
    }
    points.names.push_back(unique.Add(name));
    points.metres_per_unit = *metres;
    unit_name = unit;
  }
  if (points.names.empty()) return rows.Error("expected a column 'NAME_x_m' after time_s");
  if (std::string note = unique.Note(); !note.empty()) notes.push_back(std::move(note));
  return points;
}

}  // namespace

absl::StatusOr<MotionFile> ReadPointTable(SourceFile file, CsvRows rows,
                                          std::span<const std::string> header,
                                          const ReadOptions& options) {
  MotionFile read;
  SourceReport& report = read.report;
  MOTIONDB_ASSIGN_OR_RETURN(PointColumns points, PointsOfHeader(rows, header, report.notes));
  MOTIONDB_ASSIGN_OR_RETURN(const JointMatrix values,
                            ReadNumberRows(rows, header, EmptyCells::kMissing, false));
  const auto error = [&](Eigen::Index frame, std::string_view text) {
    return InvalidArgument("{}:{}: {}", file.name, LineOfRow(file, 1 + frame), text);
  };
  for (Eigen::Index frame = 0; frame < values.rows(); ++frame) {
    if (!std::isfinite(values(frame, 0))) return error(frame, "expected a time in seconds");
    for (Eigen::Index c = 1; c < values.cols(); c += 3) {
      const auto missing = values.block<1, 3>(frame, c).array().isNaN().count();
      if (missing == 0 || missing == 3) continue;
      return error(frame, fmt::format("expected all three coordinates of '{}' or none, found {}",
                                      Shown(points.names[(c - 1) / 3]), 3 - missing));
    }
  }
  double rate_hz = options.frame_rate_hz.value_or(kSingleFrameRate_hz);
  if (!options.frame_rate_hz && values.rows() > 1) {
    MOTIONDB_ASSIGN_OR_RETURN(rate_hz, FrameRateOfTimes(file, values.col(0), 1, report.notes));
  } else if (!options.frame_rate_hz) {
    report.notes.push_back(fmt::format("frame rate {} Hz (assumed)", rate_hz));
  }
  if (auto note = NoteOnFileEnd(TextScanner(file))) report.notes.push_back(*std::move(note));

  DecideUnit({.given = options.metres_per_unit,
              .stated = points.metres_per_unit,
              .deduced = {},
              .fallback = 1},
             report);
  DecideUpAxis(
      {.given = options.up_axis, .stated = UpAxis::kZ, .deduced = {}, .fallback = UpAxis::kZ},
      report);
  FrameMatrix positions = values.rightCols(values.cols() - 1).cast<float>();
  ToWorld(report, positions);
  read.motion = MarkerMotion{.names = std::move(points.names),
                             .frame_rate_hz = rate_hz,
                             .positions_m = std::move(positions)};
  return read;
}

}  // namespace motiondb::core
