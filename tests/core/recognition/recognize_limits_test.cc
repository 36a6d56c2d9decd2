// Memory limits of Recognize, checked before it begins.
#include <catch2/catch.hpp>

#include "core/recognition/recognize.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::recognize_limits_test {
namespace {

using Catch::Contains;

core::StateSequence Long(const core::Model& model, int frames) {
  core::StateSequence states = WanderingClips(1, 8, model.marker_set(), 3).front().states;
  states.states = core::FrameMatrix(states.states.row(0).replicate(frames, 1));
  states.root_path = core::RootPath(states.root_path.row(0).replicate(frames, 1));
  return states;
}

TEST_CASE("Recognize: refuses too many windows", "[core][recognition][hostile]") {
  const core::Model model = SmallModel(80, 20, 2, 8, 5);
  core::RecognizeOptions options;
  options.hop_seconds = 1e-9;
  for (const core::Method method : {core::Method::kBest, core::Method::kPaper}) {
    options.method = method;
    const auto windows = core::Recognize(model, Long(model, 130'000), options);
    REQUIRE(windows.status().code() == absl::StatusCode::kInvalidArgument);
    CHECK_THAT(std::string(windows.status().message()), Contains("hop_seconds: "));
  }
}

TEST_CASE("Recognize: refuses many paths of long windows", "[core][recognition][hostile]") {
  const core::Model model = SmallModel(3, 200, 2, 4, 5);
  core::RecognizeOptions options;
  options.method = core::Method::kPaper;
  options.generation = core::Generation::kTopPaths;
  options.path_count = 100;
  options.whole = true;
  const int nodes = model.tree().node_count(model.layer_count());
  const auto windows = core::Recognize(model, Long(model, (1 << 26) / 100 / nodes + 1), options);
  REQUIRE(windows.status().code() == absl::StatusCode::kInvalidArgument);
  CHECK_THAT(std::string(windows.status().message()), Contains("path_count: "));
}

TEST_CASE("Recognize: can be cancelled within a clip", "[core][recognition][hostile]") {
  constexpr int kClips = 3;
  const core::Model model = SmallModel(kClips, 1500, 2, 8, 5);
  const core::StateSequence observation = Long(model, 8000);
  core::RecognizeOptions options;
  options.whole = true;
  for (const core::Method method : {core::Method::kBest, core::Method::kPaper}) {
    options.method = method;
    int polls = 0;
    const auto answer = core::Recognize(model, observation, options, [&] {
      ++polls;
      return false;
    });
    REQUIRE(answer.ok());
    CAPTURE(method);
    CHECK(polls > 4 * kClips);
    const int poll_count = polls;
    for (int at = 1; at <= poll_count; at += 1 + poll_count / 8) {
      polls = 0;
      const auto ended =
          core::Recognize(model, observation, options, [&] { return ++polls >= at; });
      CHECK(ended.status().code() == absl::StatusCode::kCancelled);
      CHECK(polls <= at + 1);
    }
  }
}

}  // namespace
}  // namespace motiondb::tests::recognize_limits_test
