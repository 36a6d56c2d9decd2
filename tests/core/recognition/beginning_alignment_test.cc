#include "core/recognition/beginning_alignment.h"

#include <catch2/catch.hpp>
#include <vector>

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
                          const std::vector<bool>& left_out) {
  const auto together = core::AlignBeginnings(model, beginnings, left_out);
  REQUIRE(together.size() == beginnings.lengths.size());
  for (std::size_t b = 0; b < together.size(); ++b) {
    const int length = beginnings.lengths[b];
    CAPTURE(length);
    core::FrameMatrix states = beginnings.states.topRows(length);
    states.bottomRows(1) = beginnings.newest.row(static_cast<Eigen::Index>(b));
    const auto observation = core::MetricObservation::Create(model, states);
    REQUIRE(observation.ok());
    const int stride = core::FrameStride(model.settings().frame_rate_hz);
    const auto alone = core::AlignWindow(
        model, *observation, core::ComparedFrames(0, length, stride, true), left_out, true, {});
    REQUIRE(alone.ok());
    CHECK(together[b].frames == alone->frames);
    CHECK(together[b].energy == Approx(alone->energy));
    CHECK(together[b].noise == Approx(alone->noise));
    CHECK(together[b].familiarity_score == Approx(alone->familiarity_score).epsilon(1e-4));
    REQUIRE(together[b].clips.size() == alone->clips.size());
    for (std::size_t i = 0; i < alone->clips.size(); ++i) {
      CHECK(together[b].clips[i].clip == alone->clips[i].clip);
      CHECK(together[b].clips[i].log_evidence == alone->clips[i].log_evidence);
    }
  }
}

}  // namespace

TEST_CASE("AlignBeginnings: equals separate alignment of each beginning", "[core][recognition]") {
  const core::Model model = SmallModel(12, 150, 3, 8, 1);
  std::vector<bool> left_out(12);
  left_out[3] = left_out[7] = true;
  CheckAgainstSeparate(model, BeginningsOf(model, 3, {2, 15, 30, 60, 90, 150}), left_out);
  CheckAgainstSeparate(model, BeginningsOf(model, 7, {1, 1, 2, 2, 3, 3, 149, 150}), left_out);
  CheckAgainstSeparate(model, BeginningsOf(model, 0, {150}), left_out);
}

TEST_CASE("AlignBeginnings: uses the shortlist of each beginning", "[core][recognition]") {
  const core::Model model = SmallModel(90, 60, 3, 8, 2);  // a shortlist has 64
  CheckAgainstSeparate(model, BeginningsOf(model, 5, {6, 12, 24, 48, 60}), std::vector<bool>(90));
}

TEST_CASE("AlignBeginnings: equals separate alignment if roots are raised", "[core][recognition]") {
  const core::Model model = SmallModel(8, 120, 3, 8, 3);
  core::Beginnings far = BeginningsOf(model, 2, {10, 40, 80, 120});
  far.states *= 40;
  far.newest *= 40;
  CheckAgainstSeparate(model, far, std::vector<bool>(8));
}

}  // namespace motiondb::tests::beginning_alignment_test
