#include "core/recognition/beginning_alignment.h"

#include <catch2/catch.hpp>
#include <vector>

#include "core/model/clip_mask.h"
#include "core/model/label_units.h"
#include "core/model/model.h"
#include "core/recognition/metric_observation.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::beginning_alignment_test {
namespace {

// The newest frames differ slightly from the stored ones, as with one-sided velocities.
core::Beginnings BeginningsOf(const core::Model& model, int clip, const std::vector<int>& lengths) {
  const core::ModelClip& stored = model.clips()[clip];
  core::Beginnings beginnings;
  beginnings.states = model.states().middleRows(stored.first_frame, stored.frame_count);
  beginnings.lengths = lengths;
  beginnings.newest.resize(std::ssize(lengths), beginnings.states.cols());
  for (std::size_t b = 0; b < lengths.size(); ++b) {
    beginnings.newest.row(static_cast<Eigen::Index>(b)) =
        1.1F * beginnings.states.row(lengths[b] - 1);
  }
  return beginnings;
}

void CheckAgainstSeparate(const core::Model& model, const core::Beginnings& beginnings,
                          const core::ClipMask* mask = nullptr) {
  const auto together = core::AlignBeginnings(model, *model.action_units(), beginnings, mask);
  REQUIRE(together.size() == beginnings.lengths.size());
  for (std::size_t b = 0; b < together.size(); ++b) {
    const int length = beginnings.lengths[b];
    CAPTURE(length);
    core::FrameMatrix states = beginnings.states.topRows(length);
    states.bottomRows(1) = beginnings.newest.row(static_cast<Eigen::Index>(b));
    const auto observation = core::MetricObservation::Create(model, states);
    REQUIRE(observation.ok());
    const int stride = core::FrameStride(model.settings().frame_rate_hz);
    const auto alone =
        core::AlignWindow(model, *model.action_units(), *observation,
                          core::ComparedFrames(0, length, stride, true), mask, true, {});
    REQUIRE(alone.ok());
    CHECK(together[b].frames == alone->frames);
    CHECK(together[b].noise == Approx(alone->noise));
    CHECK(together[b].familiarity_score == Approx(alone->familiarity_score).epsilon(1e-4));
    REQUIRE(together[b].units.size() == alone->units.size());
    for (std::size_t i = 0; i < alone->units.size(); ++i) {
      CHECK(together[b].units[i].unit == alone->units[i].unit);
      CHECK(together[b].units[i].log_evidence == alone->units[i].log_evidence);
    }
  }
}

}  // namespace

TEST_CASE("AlignBeginnings: equals separate alignment of each beginning", "[core][recognition]") {
  const core::Model model = SmallModel(12, 150, 3, 8, 1);
  std::vector<bool> allowed(12, true);
  allowed[3] = allowed[7] = false;
  const auto mask = core::ClipMask::Create(model, allowed);
  REQUIRE(mask.ok());
  CheckAgainstSeparate(model, BeginningsOf(model, 3, {2, 15, 30, 60, 90, 150}), mask->get());
  CheckAgainstSeparate(model, BeginningsOf(model, 7, {1, 1, 2, 2, 3, 3, 149, 150}), mask->get());
  CheckAgainstSeparate(model, BeginningsOf(model, 0, {150}), mask->get());
}

TEST_CASE("AlignBeginnings: uses the shortlist of each beginning", "[core][recognition]") {
  const core::Model model = SmallModel(90, 60, 3, 8, 2);  // a shortlist has 64
  CheckAgainstSeparate(model, BeginningsOf(model, 5, {6, 12, 24, 48, 60}));
}

TEST_CASE("AlignBeginnings: equals separate alignment if roots are raised", "[core][recognition]") {
  const core::Model model = SmallModel(8, 120, 3, 8, 3);
  core::Beginnings far = BeginningsOf(model, 2, {10, 40, 80, 120});
  far.states *= 40;
  far.newest *= 40;
  CheckAgainstSeparate(model, far);
}

}  // namespace motiondb::tests::beginning_alignment_test
