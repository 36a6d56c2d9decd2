#include <catch2/catch.hpp>
#include <limits>
#include <set>

#include "core/model/label_units.h"
#include "core/model/model.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::frame_pairs_test {
namespace {

using core::IndexPair;

// Returns one unit for each label; empty: no label.
std::vector<core::LabelUnit> UnitsOf(const std::vector<std::string>& labels) {
  std::vector<core::ModelClip> clips;
  for (const std::string& label : labels) clips.push_back({"", label, 0, 1, 1, ""});
  return core::LabelUnits(clips, 60, core::kActionTrack).all();
}

double Cost(const core::FrameMatrix& observed, const core::FrameMatrix& reference, int i, int j) {
  return (observed.row(i) - reference.row(j)).cast<double>().squaredNorm();
}

// Returns the minimum cost of all paths from (i, j).
double MinCostFrom(const core::FrameMatrix& observed, const core::FrameMatrix& reference, int i,
                   int j) {
  if (j >= reference.rows()) return std::numeric_limits<double>::infinity();
  const double here = Cost(observed, reference, i, j);
  if (i + 1 == observed.rows()) return here;
  double min_cost = std::numeric_limits<double>::infinity();
  for (int step = 0; step <= 2; ++step) {
    min_cost = std::min(min_cost, MinCostFrom(observed, reference, i + 1, j + step));
  }
  return here + min_cost;
}

}  // namespace

TEST_CASE("AlignFrames: finds the path with the lowest cost", "[core][model]") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const int dimensions = 3;
    const core::FrameMatrix observed = WanderingStates(6, dimensions, seed);
    const core::FrameMatrix reference =
        WanderingStates(3 + static_cast<int>(seed % 7), dimensions, seed + 100);
    double min_cost = std::numeric_limits<double>::infinity();
    for (int start = 0; start < 4; ++start) {
      min_cost = std::min(min_cost,
                          0.05 * dimensions * start + MinCostFrom(observed, reference, 0, start));
    }
    const auto pairs = core::AlignFrames(observed, reference);
    REQUIRE(pairs.size() == 6);
    double cost = 0.05 * dimensions * pairs.front().reference;
    for (int i = 0; i < 6; ++i) {
      REQUIRE(pairs[i].observed == i);
      if (i > 0) {
        CHECK(pairs[i].reference >= pairs[i - 1].reference);
        CHECK(pairs[i].reference <= pairs[i - 1].reference + 2);
      }
      cost += Cost(observed, reference, i, pairs[i].reference);
    }
    CHECK(cost == Approx(min_cost).epsilon(1e-4));
  }
}

TEST_CASE("AlignFrames: a motion is aligned with itself frame by frame", "[core][model]") {
  const core::FrameMatrix motion = WanderingStates(40, 6, 3);
  const auto pairs = core::AlignFrames(motion, motion);
  for (int i = 0; i < 40; ++i) CHECK(pairs[i] == IndexPair{i, i});
}

TEST_CASE("UnitPairs: pairs units of one label, each with at most eight references",
          "[core][model]") {
  CHECK(core::UnitPairs(UnitsOf({"a", "b", "c"})).empty());
  CHECK(core::UnitPairs(UnitsOf({"", "", "c"})).empty());
  CHECK(core::UnitPairs(UnitsOf({"a", "b", "a"})) == std::vector<IndexPair>{{0, 2}, {2, 0}});

  std::vector<std::string> labels(1000, "many");
  labels[3] = labels[500] = "two";
  labels[7] = "one";
  const auto pairs = core::UnitPairs(UnitsOf(labels));
  std::set<int> observed;
  std::set<std::pair<int, int>> different;
  for (const IndexPair& pair : pairs) {
    CHECK(labels[pair.observed] == labels[pair.reference]);
    CHECK(pair.observed != pair.reference);
    observed.insert(pair.observed);
    different.insert({pair.observed, pair.reference});
  }
  CHECK(observed.size() == 256);
  CHECK(different.size() == pairs.size());
  CHECK(pairs.size() <= 8 * 256);
}

}  // namespace motiondb::tests::frame_pairs_test
