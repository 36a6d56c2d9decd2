#include "core/inspection/inspection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <variant>
#include <vector>

#include "core/format/marker_set_file.h"
#include "core/format/marker_set_tokens.h"
#include "core/format/plausibility.h"
#include "core/mapping/figure.h"
#include "core/mapping/fit_scheme.h"
#include "core/motion/error.h"
#include "core/motion/marker_set.h"
#include "core/motion/samples.h"
#include "core/motion/states.h"

namespace motiondb::core {
namespace {

using Position = Eigen::Vector3d;

class Positions {
 public:
  explicit Positions(const MarkerMotion& motion) : motion_(motion) {}

  Position At(Eigen::Index frame, std::string_view marker) const {
    const auto found = std::ranges::find(motion_.names, marker) - motion_.names.begin();
    return motion_.positions_m.row(frame).segment<3>(3 * found).transpose().cast<double>();
  }

  // Median distance of two markers.
  std::optional<double> Distance(std::string_view a, std::string_view b) const {
    std::vector<double> distances;
    for (Eigen::Index t = 0; t < motion_.positions_m.rows(); ++t) {
      const double distance = (At(t, a) - At(t, b)).norm();
      if (std::isfinite(distance)) distances.push_back(distance);
    }
    if (distances.empty()) return std::nullopt;
    return Quantile(distances, 0.5);
  }

 private:
  const MarkerMotion& motion_;
};

// Adds the horizontal speeds of a marker in the frames in which it is near the floor.
void AddSpeedsOnFloor(const MarkerMotion& motion, std::string_view marker, double leg_length_m,
                      std::vector<double>& speeds) {
  constexpr double kNear = 0.02;       // above its lowest height, in leg lengths
  constexpr double kLowest = 0.05;     // fraction of frames
  constexpr double kMinSeconds = 0.1;  // on the floor
  const Positions positions(motion);
  const auto frames = static_cast<int>(motion.positions_m.rows());
  std::vector<double> heights;
  for (int t = 0; t < frames; ++t) {
    const double height = positions.At(t, marker).z();
    if (std::isfinite(height)) heights.push_back(height);
  }
  if (heights.empty()) return;
  const double limit = Quantile(heights, kLowest) + kNear * leg_length_m;
  const auto is_low = [&](int t) { return positions.At(t, marker).z() <= limit; };
  const int min_frames = std::max(2, static_cast<int>(kMinSeconds * motion.frame_rate_hz));
  for (int first = 0; first < frames;) {
    int end = first;
    while (end < frames && is_low(end)) ++end;
    for (int t = first + 1; end - first >= min_frames && t < end; ++t) {
      const Position step = positions.At(t, marker) - positions.At(t - 1, marker);
      speeds.push_back(step.head<2>().norm() * motion.frame_rate_hz);
    }
    first = end + 1;
  }
}

}  // namespace

std::optional<double> Stature(const MarkerMotion& motion, double leg_length_m) {
  constexpr double kAnkleHeight = 0.039;  // of the stature: Winter, after Drillis and Contini
  const Positions positions(motion);
  double length = leg_length_m;
  constexpr const char* kLine[] = {"Pelvis", "Waist", "Spine", "Neck", "Head", "HeadTop"};
  for (std::size_t i = 1; i < std::size(kLine); ++i) {
    const auto segment = positions.Distance(kLine[i - 1], kLine[i]);
    if (!segment) return std::nullopt;
    length += *segment;
  }
  return length / (1 - kAnkleHeight);
}

std::optional<double> FootSlide(const MarkerMotion& motion, double leg_length_m) {
  std::vector<double> speeds;
  for (const char* const marker : {"LHeel", "RHeel", "LToe", "RToe"}) {
    AddSpeedsOnFloor(motion, marker, leg_length_m, speeds);
  }
  if (speeds.empty()) return std::nullopt;
  return Quantile(speeds, 0.5);
}

namespace {

// The marker of standard34 that is at a role, without its side.
struct MarkerOfRole {
  const char* marker;
  Role role;
  bool has_sides;
};
constexpr MarkerOfRole kMarkers[] = {
    {"Hip", Role::kHip, true},          {"Knee", Role::kKnee, true},
    {"Ankle", Role::kAnkle, true},      {"Toe", Role::kToe, true},
    {"Waist", Role::kSpine, false},     {"Spine", Role::kSpine, false},
    {"Neck", Role::kNeck, false},       {"Head", Role::kHead, false},
    {"HeadTop", Role::kHeadTop, false}, {"Shoulder", Role::kShoulder, true},
    {"Elbow", Role::kElbow, true},      {"Wrist", Role::kWrist, true},
    {"Hand", Role::kHand, true}};

}  // namespace

std::string DraftMapping(const MarkerSet& set, const PointCloud& points, const std::string& name) {
  const Figure figure = FindFigure(points);
  std::string text =
      fmt::format("# A draft: complete the rules of all markers of {}.\nmapping {}\n", set.name,
                  QuotedName(name));
  for (const auto& [marker, role, has_sides] : kMarkers) {
    for (const Side side : {Side::kLeft, Side::kRight}) {
      if (!has_sides && side == Side::kRight) continue;
      const char* const letter = !has_sides ? "" : side == Side::kLeft ? "L" : "R";
      RolePoint point = figure.at(role, side);
      if (role == Role::kSpine && !figure.spine.empty()) {
        const std::size_t at = std::string_view(marker) == "Waist" ? 0 : figure.spine.size() / 2;
        point = {figure.spine[at], 1};
      }
      text += point.is_found()
                  ? fmt::format("{}{} = {}  # confidence {:.2f}\n", letter, marker,
                                QuotedName(figure.names[point.index]), point.confidence)
                  : fmt::format("# {}{} = ?\n", letter, marker);
    }
  }
  return text;
}

namespace {

constexpr double kUsualRate_hz = 60;  // of a new database

std::vector<InspectedPoint> PointsOf(const Motion& motion, const PointCloud& middle) {
  std::vector<InspectedPoint> points(static_cast<std::size_t>(middle.count()));
  for (int i = 0; i < middle.count(); ++i) {
    points[i].name = middle.names[i];
    if (!middle.parents.empty()) points[i].parent = middle.parents[i];
    const Eigen::Vector3d position = middle.frames.front().col(i);
    points[i].position_m = {position.x(), position.y(), position.z()};
  }
  if (const auto* markers = std::get_if<MarkerMotion>(&motion)) {
    const double frames =
        static_cast<double>(std::max<Eigen::Index>(1, markers->positions_m.rows()));
    for (int i = 0; i < middle.count(); ++i) {
      points[i].missing =
          static_cast<double>(markers->positions_m.col(3 * i).array().isNaN().count()) / frames;
    }
  }
  return points;
}

// Returns the positions in the frame in the middle of the motion.
PointCloud MiddleFrame(const Motion& motion) {
  PointCloud points = SamplePoints(motion, 3);
  if (points.frames.size() > 1) points.frames.front() = points.frames[points.frames.size() / 2];
  if (points.frames.empty()) {
    points.frames.emplace_back(
        Eigen::Matrix3Xd::Constant(3, points.count(), std::numeric_limits<double>::quiet_NaN()));
  }
  return points;
}

// Returns the name of a file without folders and extension.
std::string Stem(std::string_view path) {
  path.remove_prefix(path.find_last_of('/') + 1);  // npos + 1 is 0
  const std::string_view stem = path.substr(0, path.rfind('.'));
  return std::string(stem.empty() ? "mapping" : stem);
}

std::string MappingFile(const std::string& lines) {
  return fmt::format("motiondb-marker-set 1\nextend {}\n{}", StandardScheme().set.name, lines);
}

// Returns the scheme with the mapping that fits the motion, and describes it. Nothing if there is
// none.
std::optional<MarkerScheme> MapPoints(const Motion& motion, const PointCloud& points,
                                      const std::string& name, Inspection& inspection) {
  const MarkerScheme& standard = StandardScheme();
  if (const auto bound = BindMapping(standard, points.names); bound.ok()) {
    inspection.mapping = fmt::format("mapping '{}'", bound->name);
    const auto found = std::ranges::find(standard.mappings, bound->name, &MarkerMapping::name);
    if (found != standard.mappings.end()) {
      inspection.mapping_file = MappingFile(WriteMapping(standard.set, *found));
    }
    return standard;
  }
  auto scheme = FitScheme(standard, motion, FitFor::kClip, &inspection.mapping);
  if (!scheme.ok()) {
    inspection.problems.emplace_back(scheme.status().message());
    inspection.mapping_file = MappingFile(DraftMapping(standard.set, points, name));
    return std::nullopt;
  }
  scheme->mappings.front().name = name;
  inspection.mapping_file = MappingFile(WriteMapping(scheme->set, scheme->mappings.front()));
  return *std::move(scheme);
}

void AddProblem(const absl::Status& status, Inspection& inspection) {
  if (status.ok()) return;
  inspection.problems.emplace_back(status.message());
  if (const auto option = status.GetPayload(fmt::format("{}option", kMetadataUrl))) {
    inspection.suggested_options.emplace_back(*option);
  }
}

// Converts the motion to states, and measures the body.
void Measure(const MarkerScheme& scheme, const Motion& motion, std::optional<double> leg_length_m,
             Inspection& inspection) {
  const auto states = Represent(scheme, motion, inspection.frame_rate_hz, GlitchPolicy::kRepair,
                                leg_length_m, &inspection.notes);
  if (!states.ok()) return AddProblem(states.status(), inspection);
  inspection.leg_length_m = states->leg_length_m;
  AddProblem(CheckBodySize(scheme.set, *states, inspection.report), inspection);
  AddProblem(CheckPosture(scheme.set, *states, inspection.report), inspection);
  const MarkerMotion markers{scheme.set.markers, states->frame_rate_hz, WorldPositions(*states)};
  inspection.stature_m = Stature(markers, states->leg_length_m);
  inspection.foot_slide_m_per_s = FootSlide(markers, states->leg_length_m);
}

}  // namespace

Inspection InspectMotion(std::string_view file_name, const MotionFile& read,
                         std::optional<double> leg_length_m) {
  Inspection inspection;
  inspection.report = read.report;
  inspection.take = read.take;
  inspection.takes = read.takes;
  if (const auto* joints = std::get_if<JointMotion>(&read.motion)) {
    inspection.has_hierarchy = true;
    inspection.frame_rate_hz = joints->frame_rate_hz;
    inspection.frame_count = static_cast<int>(joints->angles.rows());
  } else {
    const auto& markers = std::get<MarkerMotion>(read.motion);
    inspection.frame_rate_hz = markers.frame_rate_hz;
    inspection.frame_count = static_cast<int>(markers.positions_m.rows());
  }
  inspection.points = PointsOf(read.motion, MiddleFrame(read.motion));
  const PointCloud points = SamplePoints(read.motion);
  for (const FoundRole& found : FindRoles(points)) {
    inspection.points[found.point].role = found.role;
    inspection.points[found.point].confidence = found.confidence;
  }
  if (leg_length_m) AddProblem(CheckGivenLegLength(*leg_length_m), inspection);
  AddProblem(CheckFrameRate(inspection.frame_rate_hz, kUsualRate_hz), inspection);
  const auto scheme = MapPoints(read.motion, points, Stem(file_name), inspection);
  if (scheme) Measure(*scheme, read.motion, leg_length_m, inspection);
  return inspection;
}

}  // namespace motiondb::core
