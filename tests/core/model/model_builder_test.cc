#include "core/model/model_builder.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <thread>

#include "tests/support/synthetic_states.h"

namespace motiondb::tests::model_builder_test {
namespace {

void RunOnThreeThreads(int count, const std::function<void(int)>& body) {
  std::vector<std::thread> threads;
  for (int first = 0; first < 3; ++first) {
    threads.emplace_back([=, &body] {
      for (int i = count - 1 - first; i >= 0; i -= 3) body(i);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

template <typename Matrix>
bool SameBytes(const Matrix& a, const Matrix& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::equal(a.data(), a.data() + a.size(), b.data());
}

}  // namespace

TEST_CASE("BuildModel: bitwise identical for any number of threads", "[core][model]") {
  const core::MarkerSet set = SmallMarkerSet(3);
  core::BuildSettings settings;
  settings.min_frames = 8;
  const auto serial =
      core::BuildModel(settings, set, WanderingClips(5, 300, set, 1), core::RunSerially, {});
  const auto parallel =
      core::BuildModel(settings, set, WanderingClips(5, 300, set, 1), RunOnThreeThreads, {});
  REQUIRE((serial.ok() && parallel.ok()));
  const core::ModelParts& a = serial->parts();
  const core::ModelParts& b = parallel->parts();
  CHECK(SameBytes(a.states.view(), b.states.view()));
  CHECK(SameBytes(a.gaussians.means(), b.gaussians.means()));
  CHECK(SameBytes(a.gaussians.variances(), b.gaussians.variances()));
  CHECK(a.tree.frame_order() == b.tree.frame_order());
  CHECK(a.familiarity.scores == b.familiarity.scores);
  for (std::size_t l = 0; l < a.global_graphs.size(); ++l) {
    CHECK(a.global_graphs[l].edges() == b.global_graphs[l].edges());
  }
}

TEST_CASE("BuildModel: probabilities sum to 1; clip counts sum to the global counts",
          "[core][model]") {
  const core::Model model = SmallModel(5, 200, 3, 8, 2);
  for (int layer = 1; layer <= model.layer_count(); ++layer) {
    const core::TransitionGraph& global = model.global_graph(layer);
    long clip_transitions = 0;
    for (int clip = 0; clip < static_cast<int>(model.clips().size()); ++clip) {
      const core::ClipGraph graph = *model.clip_graph(layer, clip);
      for (int from = 0; from < graph.transitions.node_count(); ++from) {
        double sum = 0;
        for (const core::Edge& edge : graph.transitions.row(from)) {
          sum += graph.transitions.probability(from, edge.to);
          clip_transitions += edge.count;
        }
        if (graph.transitions.row_sum(from) > 0) CHECK(sum == Approx(1));
      }
    }
    long global_transitions = 0;
    for (int from = 0; from < global.node_count(); ++from) {
      double sum = 0;
      for (const core::Edge& edge : global.row(from)) {
        sum += global.probability(from, edge.to);
        global_transitions += edge.count;
      }
      if (global.row_sum(from) > 0) CHECK(sum == Approx(1));
    }
    CHECK(global_transitions == clip_transitions);
    CHECK(global_transitions == 5 * 199);  // no transition between clips
  }
}

TEST_CASE("BuildModel: clips are consecutive frames in the given order", "[core][model]") {
  const core::Model model = SmallModel(3, 50, 2, 8, 3);
  REQUIRE(model.clips().size() == 3);
  for (int c = 0; c < 3; ++c) {
    CHECK(model.clips()[c].id == "clip" + std::to_string(c));
    CHECK(model.clips()[c].first_frame == 50 * c);
    CHECK(model.clip_of_frame(50 * c) == c);
    CHECK(model.clip_of_frame(50 * c + 49) == c);
  }
  CHECK(*model.ResolveLayer(0) == model.layer_count());
  CHECK(*model.ResolveLayer(1) == 1);
  CHECK(model.ResolveLayer(model.layer_count() + 1).status().code() ==
        absl::StatusCode::kOutOfRange);
}

TEST_CASE("BuildModel: rejects invalid clips, and can be cancelled", "[core][model]") {
  const core::MarkerSet set = SmallMarkerSet(2);
  const auto code = [&](std::vector<core::BuildInput> inputs, core::BuildProgress progress = {}) {
    return core::BuildModel({}, set, std::move(inputs), core::RunSerially, progress)
        .status()
        .code();
  };
  using absl::StatusCode;
  CHECK(code({}) == StatusCode::kInvalidArgument);
  auto inputs = WanderingClips(2, 40, set, 1);
  inputs[1].states.states(3, 3) = std::nanf("");
  CHECK(code(inputs) == StatusCode::kInvalidArgument);
  inputs = WanderingClips(2, 40, set, 1);
  inputs[0].states.frame_rate_hz = 59;
  CHECK(code(inputs) == StatusCode::kInvalidArgument);
  inputs = WanderingClips(2, 40, SmallMarkerSet(3), 1);
  CHECK(code(inputs) == StatusCode::kInvalidArgument);
  CHECK(code(WanderingClips(2, 40, set, 1), [](double, std::string_view) { return false; }) ==
        StatusCode::kCancelled);
}

TEST_CASE("BuildModel: progress rises from 0 to 1", "[core][model]") {
  const core::MarkerSet set = SmallMarkerSet(2);
  double last = -1;
  const auto model = core::BuildModel({}, set, WanderingClips(2, 200, set, 1), core::RunSerially,
                                      [&](double fraction, std::string_view stage) {
                                        CHECK(fraction >= last);
                                        CHECK_FALSE(stage.empty());
                                        last = fraction;
                                        return true;
                                      });
  REQUIRE(model.ok());
  CHECK(last == 1);
}

TEST_CASE("Model: rejects inconsistent parts", "[core][model]") {
  const core::Model model = SmallModel(3, 80, 2, 8, 3);
  const auto is_rejected = [&](const std::function<void(core::ModelParts&)>& corrupt) {
    core::ModelParts parts = model.parts();
    corrupt(parts);
    return core::Model::Create(std::move(parts)).status().code() == absl::StatusCode::kDataLoss;
  };
  CHECK_FALSE(is_rejected([](core::ModelParts&) {}));
  CHECK(is_rejected(
      [](auto& p) { p.states = core::SharedRows(p.states.middleRows(0, p.states.rows() - 1)); }));
  CHECK(is_rejected([](auto& p) { p.clips.pop_back(); }));
  CHECK(is_rejected([](auto& p) { p.clips[1].first_frame += 1; }));
  CHECK(is_rejected([](auto& p) { p.scale.divisor[0] = 0; }));
  CHECK(is_rejected([](auto& p) { p.global_graphs.pop_back(); }));
  CHECK(is_rejected([](auto& p) { p.clip_graphs.pop_back(); }));
  CHECK(is_rejected([](auto& p) { p.clip_graphs.back() = nullptr; }));
  CHECK(is_rejected([](auto& p) { p.familiarity.scores.pop_back(); }));
  CHECK(is_rejected([](auto& p) {
    core::ClipGraph graph = *p.clip_graphs.back();
    graph.nodes.back() = 10000;
    p.clip_graphs.back() = std::make_shared<const core::ClipGraph>(std::move(graph));
  }));
  CHECK(is_rejected([](auto& p) { p.built_clip_count = 4; }));
}

}  // namespace motiondb::tests::model_builder_test
