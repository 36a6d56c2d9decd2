#include "core/inspection/inspection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <variant>

#include "core/format/marker_set_file.h"
#include "core/format/plausibility.h"
#include "core/inspection/body_measures.h"
#include "core/inspection/draft_mapping.h"
#include "core/mapping/figure.h"
#include "core/mapping/fit_scheme.h"
#include "core/mapping/found_roles.h"
#include "core/motion/error.h"
#include "core/motion/marker_rules.h"
#include "core/motion/states.h"

namespace motiondb::core {
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
