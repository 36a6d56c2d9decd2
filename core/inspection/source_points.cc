#include "core/inspection/source_points.h"

#include <algorithm>
#include <variant>

#include "core/format/marker_set_file.h"
#include "core/mapping/figure.h"
#include "core/mapping/fit_scheme.h"
#include "core/motion/error.h"
#include "core/motion/marker_set.h"

namespace motiondb::core {
namespace {

// Returns the motion of the first frame with the most points. REQUIRES: a frame.
Motion FullestFrame(const Motion& motion) {
  if (const auto* joints = std::get_if<JointMotion>(&motion)) {
    return JointMotion{joints->skeleton, joints->frame_rate_hz, joints->angles.topRows(1)};
  }
  const auto& markers = std::get<MarkerMotion>(motion);
  Eigen::Index best = 0;
  Eigen::Index fewest_missing = markers.positions_m.cols() + 1;
  for (Eigen::Index t = 0; t < markers.positions_m.rows() && fewest_missing > 0; ++t) {
    const Eigen::Index missing = markers.positions_m.row(t).array().isNaN().count();
    if (missing >= fewest_missing) continue;
    fewest_missing = missing;
    best = t;
  }
  return MarkerMotion{markers.names, markers.frame_rate_hz,
                      markers.positions_m.middleRows(best, 1)};
}

}  // namespace

absl::StatusOr<SourcePoints> FindSourcePoints(const MarkerScheme& scheme, const Motion& motion) {
  MOTIONDB_ASSIGN_OR_RETURN(const MarkerScheme fitted, FitScheme(scheme, motion, FitFor::kClip));
  const PointCloud cloud = SamplePoints(FullestFrame(motion), 1);
  MOTIONDB_ASSIGN_OR_RETURN(const BoundMapping mapping, BindMapping(fitted, cloud.names));
  SourcePoints found;
  const auto written = std::ranges::find(fitted.mappings, mapping.name, &MarkerMapping::name);
  if (written != fitted.mappings.end()) {
    found.mapping = mapping.name;
    found.mapping_text = WriteMapping(fitted.set, *written);
  }
  for (int i = 0; i < cloud.count(); ++i) {
    SourcePoint& point = found.points.emplace_back();
    point.name = cloud.names[i];
    if (!cloud.parents.empty()) point.parent = cloud.parents[i];
    const Eigen::Vector3d position = cloud.frames.front().col(i);
    point.position_m = {position.x(), position.y(), position.z()};
  }
  for (std::size_t m = 0; m < mapping.rules.size(); ++m) {
    const BoundRule& rule = mapping.rules[m];
    const auto add_to = [&](int point) {
      std::vector<std::string>& markers = found.points[point].markers;
      const std::string& marker = fitted.set.markers[m];
      if (markers.empty() || markers.back() != marker) markers.push_back(marker);
    };
    for (const auto& [point, weight] : rule.points) {
      if (weight != 0) add_to(point);
    }
    if (rule.offset_joint >= 0) add_to(rule.offset_joint);
  }
  return found;
}

}  // namespace motiondb::core
