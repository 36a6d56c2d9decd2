// Automatic mapping of the published skeletons and labelled points of many tools, on the body and
// the motion of a recorded person.
#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "core/format/marker_set_file.h"
#include "core/mapping/fit_scheme.h"
#include "core/motion/states.h"
#include "tests/core/mapping/convention_body.h"
#include "tests/core/mapping/conventions/skeleton_conventions.h"
#include "tests/support/real_data.h"
#include "tests/support/real_motion.h"

namespace motiondb::tests::conventions_test {
namespace {

constexpr double kMaxMedian = 0.08;  // leg lengths
constexpr double kMaxError = 0.35;   // of any marker, leg lengths

// Not mapped yet, or with a marker that is off by more than kMaxError.
const std::set<std::string> kUnsupported = {
    // Two joints fold back or lie in the place of others.
    "second_life_avatar_bento", "human36m_32_repeated_names",
    // Names of one or two letters, several joints in one place.
    "kit_mmm", "kit_mmm_segment_joints", "kit_ml_21",
    // Names that mean other points elsewhere.
    "nuitrack", "mpi_inf_3dhp_28"};

// Returns the median and the maximum over the markers of their median distances, leg lengths.
// Missing markers do not count.
std::pair<double, double> Errors(const core::MarkerMapping& mapping, const core::PointCloud& points,
                                 const std::vector<ConventionBody>& bodies, double leg) {
  const core::MarkerSet& set = core::StandardScheme().set;
  std::vector<double> medians;
  for (std::size_t m = 0; m < mapping.rules.size(); ++m) {
    if (mapping.rules[m].points.empty()) continue;
    std::vector<double> distances;
    for (std::size_t f = 0; f < bodies.size(); ++f) {
      Eigen::Vector3d position = Eigen::Vector3d::Zero();
      for (const core::WeightedPoint& point : mapping.rules[m].points) {
        const auto at = std::ranges::find(points.names, point.name) - points.names.begin();
        position += point.weight * points.frames[f].col(at);
      }
      distances.push_back((position - bodies[f].marker(set.markers[m])).norm() / leg);
    }
    std::ranges::nth_element(distances, distances.begin() + std::ssize(distances) / 2);
    medians.push_back(distances[distances.size() / 2]);
  }
  std::ranges::sort(medians);
  return {medians[medians.size() / 2], medians.back()};
}

std::string RolesText(const core::PointCloud& points) {
  std::string text;
  for (const core::FoundRole& found : core::FindRoles(points)) {
    text += fmt::format("{:14} {:24} {:.2f}\n", found.role, points.names[found.point],
                        found.confidence);
  }
  return text;
}

TEST_CASE("MapFigure: published skeletons and labelled points of many tools", "[core][mapping]") {
  MOTIONDB_REQUIRE_DATA();
  const core::MarkerScheme& scheme = core::StandardScheme();
  const auto markers = core::ApplyScheme(scheme, LoadMotion(DataDir() / "cmu/02/02_01.amc").motion);
  REQUIRE(markers.ok());
  const double leg = *core::EstimateLegLength(scheme.set, *markers);
  std::vector<ConventionBody> bodies;
  for (int i = 0; i < 24; ++i) {
    bodies.emplace_back(*markers, i * (markers->positions_m.rows() - 1) / 23, leg);
  }
  int count = 0;
  for (const std::string_view tables :
       {GameEngineConventions(), ContentToolConventions(), MocapSuitConventions(),
        CmuAndResearchConventions(), BodyModelConventions(), CameraConventions(),
        MarkerSetConventions()}) {
    for (const Convention& convention : ReadConventions(tables)) {
      CAPTURE(convention.name);
      ++count;
      const core::PointCloud points = PointsOf(convention, bodies);
      const auto found = core::MapAutomatically(scheme.set, points);
      INFO(found.status().ToString() << '\n' << RolesText(points));
      bool is_supported = found.ok();
      if (is_supported) {
        const auto [median, maximum] = Errors(found->mapping, points, bodies, leg);
        CAPTURE(median, maximum);
        is_supported = median < kMaxMedian && maximum < kMaxError;
      }
      CHECK(is_supported == !kUnsupported.contains(convention.name));
    }
  }
  CHECK(count == 142);
}

}  // namespace
}  // namespace motiondb::tests::conventions_test
