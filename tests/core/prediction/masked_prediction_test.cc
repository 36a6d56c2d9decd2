// Prediction from some clips, compared with exhaustive computations over these clips alone.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "core/inference/node_path.h"
#include "core/inference/observation.h"
#include "core/model/clip_graphs.h"
#include "core/prediction/forecast.h"
#include "core/prediction/predict.h"
#include "tests/support/some_clips.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::masked_prediction_test {
namespace {

constexpr int kClips = 8;
constexpr int kFrames = 150;

core::StateSequence Past(const core::Model& model, unsigned seed) {
  return core::PastAt(WanderingClips(4, 60, model.marker_set(), 41)[seed % 4].states, 45, 24);
}

// Returns the frames of the allowed clips nearest to the last state of `past`, nearest first.
std::vector<int> NearestAllowed(const core::Model& model, const core::ClipMask& mask,
                                const core::StateSequence& past, int count) {
  const core::FrameMatrix scaled = *core::ScaledObservation(model, past);
  std::vector<std::pair<double, int>> distances;
  for (int frame = 0; frame < model.frame_count(); ++frame) {
    if (!mask.allows(model.clip_of_frame(frame))) continue;
    distances.emplace_back((model.states().row(frame) - scaled.bottomRows(1)).squaredNorm(), frame);
  }
  std::ranges::sort(distances);
  std::vector<int> frames;
  for (int i = 0; i < std::min<int>(count, static_cast<int>(distances.size())); ++i) {
    frames.push_back(distances[i].second);
  }
  return frames;
}

}  // namespace

TEST_CASE("Predict: with a mask the next nodes follow the allowed clips' transitions",
          "[core][prediction]") {
  const core::Model model = SmallModel(kClips, kFrames, 4, 8, 41);
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const auto mask = SomeClips(model, 1 + static_cast<int>(seed) % 4, seed);
    const core::StateSequence past = Past(model, seed);
    core::PredictOptions options;
    options.mask = mask;
    options.method = seed % 2 == 0 ? core::Method::kBest : core::Method::kPaper;
    const auto prediction = core::Predict(model, past, options);
    INFO(prediction.status());
    REQUIRE(prediction.ok());
    CHECK(core::IsAllowedNode(model, prediction->layer, prediction->state.node, mask.get()));

    std::vector<core::ModelClip> clips;
    for (const int clip : mask->clips()) clips.push_back(model.clips()[clip]);
    const auto graph = core::CountGlobalGraph(model.tree(), prediction->layer, clips);
    const auto search =
        core::FindNodePaths(model, *core::ScaledObservation(model, past), {.mask = mask});
    REQUIRE(search.ok());
    const auto now = core::LastNodes(model, *search, options.transition_floor);
    REQUIRE(now.ok());
    std::map<int, double> next;
    double total = 0;
    for (const core::NodeState& state : *now) {
      const double leaving =
          static_cast<double>(graph.row_sum(state.node)) - graph.count(state.node, state.node);
      if (leaving <= 0) continue;
      total += state.probability;
      for (const core::Edge& edge : graph.row(state.node)) {
        if (edge.to != state.node) next[edge.to] += state.probability * edge.count / leaving;
      }
    }
    for (const core::NextNode& node : prediction->next_nodes) {
      CHECK(node.probability == Approx(next[node.node] / total));
      CHECK_FALSE(node.clips.empty());
      for (const int clip : node.clips) CHECK(mask->allows(clip));
    }
    const auto reported =
        std::ranges::count_if(next, [&](const auto& node) { return node.second / total >= 1e-3; });
    CHECK(std::ssize(prediction->next_nodes) == reported);
  }
}

TEST_CASE("Predict: with a mask the futures are those of the nearest allowed frames",
          "[core][prediction]") {
  const core::Model model = SmallModel(kClips, kFrames, 4, 8, 41);
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const auto mask = SomeClips(model, 1 + static_cast<int>(seed) % 4, seed);
    const core::StateSequence past = Past(model, seed);
    // The allowed clips have fewer frames than the smallest pool, so all of them are searched.
    const auto moments = core::FindMoments(model, past, 1e-6, mask, {}, {});
    REQUIRE(moments.ok());
    std::vector<int> frames;
    for (const core::StoredMoment& moment : *moments) frames.push_back(moment.frame);
    std::vector<int> expected = NearestAllowed(model, *mask, past, 256);
    std::ranges::sort(frames);
    std::ranges::sort(expected);
    CHECK(frames == expected);

    core::PredictOptions options;
    options.mask = mask;
    const auto prediction = core::PredictFrames(model, past, options);
    REQUIRE(prediction.ok());
    core::Forecaster forecaster(model, past, *moments);
    for (const core::PredictedFrame& predicted : *prediction) {
      const core::Forecast forecast = forecaster.At(predicted.seconds);
      core::StateSequence pose{past.frame_rate_hz, past.leg_length_m,
                               core::FrameMatrix::Zero(1, past.states.cols()),
                               past.root_path.bottomRows(1)};
      for (Eigen::Index m = 0; m < past.states.cols() / 6; ++m) {
        pose.states.row(0).segment<3>(6 * m) = forecast.positions.segment<3>(3 * m);
      }
      CHECK((core::WorldPositions(pose).row(0).transpose() - predicted.marker_positions_m).norm() <
            1e-5);
    }
  }
}

TEST_CASE("Predict: a mask of all clips changes nothing", "[core][prediction]") {
  const core::Model model = SmallModel(kClips, kFrames, 4, 8, 41);
  for (const core::Method method : {core::Method::kBest, core::Method::kPaper}) {
    core::PredictOptions options;
    options.method = method;
    const auto all = core::Predict(model, Past(model, 1), options);
    options.mask = SomeClips(model, kClips, 1);
    const auto masked = core::Predict(model, Past(model, 1), options);
    REQUIRE((all.ok() && masked.ok()));
    CHECK(all->state.node == masked->state.node);
    CHECK(all->state.probability == masked->state.probability);
    REQUIRE(all->next_nodes.size() == masked->next_nodes.size());
    for (std::size_t h = 0; h < all->horizons.size(); ++h) {
      CHECK(all->horizons[h].marker_positions_m == masked->horizons[h].marker_positions_m);
    }
  }
}

}  // namespace motiondb::tests::masked_prediction_test
