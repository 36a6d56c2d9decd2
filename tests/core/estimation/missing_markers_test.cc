#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/estimation/estimate.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::missing_markers_test {
namespace {

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();
constexpr int kMarkers = 6;

void Hide(core::StateSequence& clip, int frame, int marker) {
  clip.states.row(frame).segment<6>(6 * marker).setConstant(kMissing);
}

double DistanceFrom(const core::StateSequence& truth, const core::FilledFrame& filled, int marker) {
  const core::FrameMatrix world = core::WorldPositions(truth);
  return (world.row(filled.frame).segment<3>(3 * marker).transpose() -
          filled.marker_positions_m.segment<3>(3 * marker))
      .norm();
}

// Makes all markers of a clip swing together, 0.25 leg lengths to each side, twice per second, from
// the given phase. Missing markers then follow from those seen.
core::StateSequence Together(core::StateSequence clip, double phase) {
  for (Eigen::Index t = 0; t < clip.states.rows(); ++t) {
    const double angle = phase + 4 * M_PI * static_cast<double>(t) / clip.frame_rate_hz;
    for (Eigen::Index m = 0; m < clip.states.cols() / 6; ++m) {
      for (Eigen::Index d = 0; d < 3; ++d) {
        const double reach = 0.25 - 0.02 * static_cast<double>(m + d);
        clip.states(t, 6 * m + d) = static_cast<float>(
            static_cast<double>(m) + reach * std::sin(angle + static_cast<double>(d)));
        clip.states(t, 6 * m + 3 + d) =
            static_cast<float>(reach * 4 * M_PI * std::cos(angle + static_cast<double>(d)));
      }
    }
  }
  return clip;
}

core::Model ModelTogether() {
  const core::MarkerSet set = SmallMarkerSet(kMarkers);
  auto inputs = WanderingClips(3, 300, set, 5);
  double phase = 0;
  for (auto& input : inputs) input.states = Together(std::move(input.states), phase += 0.7);
  return *core::BuildModel({}, set, std::move(inputs), core::RunSerially, {});
}

}  // namespace

TEST_CASE("Estimate: an observation without gaps stays unchanged", "[core][estimation]") {
  const core::Model model = ModelTogether();
  const auto clip = Together(WanderingClips(1, 60, model.marker_set(), 5)[0].states, 1);
  const auto estimation = core::Estimate(model, clip, {.fill = core::Fill::kEveryFrame});
  REQUIRE(estimation.ok());
  CHECK(estimation->filled.empty());
}

TEST_CASE("Estimate: missing markers are estimated, those seen are kept", "[core][estimation]") {
  const core::Model model = ModelTogether();
  const auto truth = Together(WanderingClips(1, 120, model.marker_set(), 5)[0].states, 2);
  core::StateSequence clip = truth;
  for (int t = 0; t < 120; ++t) Hide(clip, t, 4);  // never seen
  for (int t = 0; t < 120; t += 3) Hide(clip, t, 5);
  const auto estimation = core::Estimate(model, clip, {.fill = core::Fill::kEveryFrame});
  REQUIRE(estimation.ok());
  REQUIRE(estimation->filled.size() == 120);
  for (const core::FilledFrame& filled : estimation->filled) {
    CHECK(DistanceFrom(truth, filled, 4) < 0.05);
    CHECK(DistanceFrom(truth, filled, 5) < 0.05);
    CHECK(DistanceFrom(truth, filled, 0) < 1e-6);
    CHECK(filled.deviations_m[4] > 0);
    CHECK((filled.deviations_m[5] > 0) == (filled.frame % 3 == 0));
    CHECK(filled.deviations_m[0] == 0);
    CHECK(filled.marker_positions_m.allFinite());
  }
  const auto last = core::Estimate(model, clip, {});
  REQUIRE(last.ok());
  REQUIRE(last->filled.size() == 1);
  CHECK(last->filled[0].frame == 119);
  CHECK(last->filled[0].marker_positions_m == estimation->filled.back().marker_positions_m);
}

TEST_CASE("Estimate: a recently seen marker has less uncertainty than one never seen",
          "[core][estimation]") {
  const core::Model model = ModelTogether();
  auto clip = Together(WanderingClips(1, 120, model.marker_set(), 5)[0].states, 4);
  for (int t = 0; t < 120; ++t) Hide(clip, t, 3);
  Hide(clip, 119, 4);
  const auto estimation = core::Estimate(model, clip, {});
  REQUIRE(estimation.ok());
  REQUIRE(estimation->filled.size() == 1);
  CHECK(estimation->filled[0].deviations_m[4] < estimation->filled[0].deviations_m[3]);
}

TEST_CASE("Estimate: an empty frame is estimated with large uncertainty", "[core][estimation]") {
  const core::Model model = SmallModel(4, 300, kMarkers, 8, 3);
  auto clip = WanderingClips(4, 120, model.marker_set(), 3)[0].states;
  const double size = clip.leg_length_m;
  for (int m = 0; m < kMarkers; ++m) {
    for (int t = 40; t < 120; ++t) Hide(clip, t, m);
  }
  const auto estimation = core::Estimate(model, clip, {});
  REQUIRE(estimation.ok());
  REQUIRE(estimation->filled.size() == 1);
  CHECK(estimation->filled[0].marker_positions_m.allFinite());
  CHECK((estimation->filled[0].deviations_m.array() > 0.02 * size).all());
}

TEST_CASE("Estimate: estimation of missing markers can be cancelled", "[core][estimation]") {
  const core::Model model = SmallModel(2, 100, kMarkers, 8, 3);
  auto clip = WanderingClips(2, 60, model.marker_set(), 3)[0].states;
  for (int t = 0; t < 60; ++t) Hide(clip, t, 1);
  int questions = 0;
  const auto counted = core::Estimate(model, clip, {.fill = core::Fill::kEveryFrame}, [&] {
    ++questions;
    return false;
  });
  REQUIRE(counted.ok());
  for (int stop_at = 1; stop_at <= questions; stop_at += 7) {
    int checks = 0;
    const auto stopped = core::Estimate(model, clip, {.fill = core::Fill::kEveryFrame},
                                        [&] { return ++checks == stop_at; });
    CHECK(stopped.status().code() == absl::StatusCode::kCancelled);
  }
}

}  // namespace motiondb::tests::missing_markers_test
