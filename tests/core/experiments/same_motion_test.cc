// One motion from five sources: distances between the virtual markers.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>

#include "core/format/marker_set_file.h"
#include "tests/support/real_data.h"
#include "tests/support/real_motion.h"

namespace motiondb::tests::same_motion_test {
namespace {

constexpr double kRate = 120;
constexpr double kScale_m = 0.84;  // leg length of the subject: states in metres of their body
constexpr int kMargin = 40;        // frames omitted at the ends; maximum time shift between sources

struct Source {
  const char* file;
  const char* difference;  // reason for the remaining distance
};

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Returns the distances of each marker with `shift` frames between the motions, m: [marker][frame].
std::vector<std::vector<double>> Distances(const core::StateSequence& a,
                                           const core::StateSequence& b, int shift) {
  std::vector<std::vector<double>> distances(static_cast<std::size_t>(a.states.cols() / 6));
  for (Eigen::Index t = kMargin; t < a.frame_count() - kMargin; ++t) {
    for (std::size_t m = 0; m < distances.size(); ++m) {
      const auto at = static_cast<Eigen::Index>(6 * m);
      distances[m].push_back(
          kScale_m *
          (a.states.row(t).segment<3>(at) - b.states.row(t + shift).segment<3>(at)).norm());
    }
  }
  return distances;
}

double OverallMedian(const std::vector<std::vector<double>>& distances) {
  std::vector<double> all;
  for (const auto& marker : distances) all.insert(all.end(), marker.begin(), marker.end());
  return Median(std::move(all));
}

}  // namespace

TEST_CASE("One motion through five sources has consistent markers", "[experiment][data]") {
  MOTIONDB_REQUIRE_DATA();
  const std::filesystem::path same = DataDir() / "formats" / "same-motion";
  const auto reference = LoadStates(DataDir() / "cmu/02/02_01.amc", kRate);
  const Source sources[] = {
      {"02_01.motionbuilder.bvh",
       "its root moves 6 % further and is 6 % higher than the AMC's, with legs of the same "
       "length"},
      {"02_01.daz.bvh", "arms of other proportions, bent further forward at the elbow"},
      {"02_01.iclone.bvh", "a character's trunk, shorter relative to its legs and leaning forward"},
      {"02_01.c3d", "markers on the skin; the AMC's solver set the feet closer together"},
  };
  std::vector<double> everything;
  std::vector<std::vector<double>> table;  // [source][marker]
  for (const Source& source : sources) {
    const auto states = LoadStates(same / source.file, kRate);
    std::vector<std::vector<double>> best;
    for (int shift = -3; shift <= 3; ++shift) {
      if (states.frame_count() + 3 < reference.frame_count() - kMargin) continue;
      auto distances = Distances(reference, states, shift);
      if (best.empty() || OverallMedian(distances) < OverallMedian(best)) {
        best = std::move(distances);
      }
    }
    REQUIRE_FALSE(best.empty());
    std::vector<double>& column = table.emplace_back();
    for (const auto& marker : best) {
      column.push_back(Median(marker));
      everything.insert(everything.end(), marker.begin(), marker.end());
    }
    std::printf("%-26s median %.1f cm  (%s)\n", source.file, 100 * OverallMedian(best),
                source.difference);
    CHECK(OverallMedian(best) < 0.065);
  }
  std::printf("median distance to 02_01.amc, cm   motionbuilder    daz  iclone     c3d\n");
  for (std::size_t m = 0; m < table[0].size(); ++m) {
    std::printf("  %-32s %13.1f %6.1f %7.1f %7.1f\n", core::StandardScheme().set.markers[m].c_str(),
                100 * table[0][m], 100 * table[1][m], 100 * table[2][m], 100 * table[3][m]);
  }
  std::printf("all sources and markers: median %.1f cm\n", 100 * Median(everything));
  CHECK(Median(everything) < 0.05);
}

}  // namespace motiondb::tests::same_motion_test
