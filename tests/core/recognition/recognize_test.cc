#include "core/recognition/recognize.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>

#include "core/graph/transition_graph.h"
#include "core/inference/observation.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::recognize_test {
namespace {

core::StateSequence Clip(const core::Model& model, int index, int frames) {
  return WanderingClips(6, frames, model.marker_set(), 31)[static_cast<std::size_t>(index)].states;
}

}  // namespace

TEST_CASE("Recognize: recognizes the label of a stored clip and ranks its clips high",
          "[core][recognition]") {
  const core::Model model = SmallModel(6, 240, 3, 8, 31);
  for (int c = 0; c < 6; ++c) {
    for (const core::Method method : {core::Method::kBest, core::Method::kPaper}) {
      core::RecognizeOptions options;
      options.method = method;
      const auto windows = core::Recognize(model, Clip(model, c, 240), options);
      REQUIRE(windows.ok());
      for (const core::RecognizedWindow& window : *windows) {
        CHECK(window.labels.front().label == (c % 2 == 0 ? "a" : "b"));
        CHECK(window.clips.size() == 6);
        double sum = 0;
        for (const core::LabelScore& label : window.labels) sum += label.probability;
        CHECK(sum == Approx(1));
        for (std::size_t i = 1; i < window.clips.size(); ++i) {
          CHECK(window.clips[i - 1].log_probability >= window.clips[i].log_probability);
        }
        CHECK(model.clips()[window.clips.front().clip].label() == window.labels.front().label);
        CHECK(window.familiarity >= 0);
        CHECK(window.familiarity <= 1);
      }
    }
  }
}

TEST_CASE("Recognize: labels and familiarity of kPaper follow from the graphs",
          "[core][recognition]") {
  const core::Model model = SmallModel(6, 120, 3, 8, 31);
  const core::StateSequence clip = Clip(model, 3, 24);
  core::RecognizeOptions options;
  options.method = core::Method::kPaper;
  const auto windows = core::Recognize(model, clip, options);
  REQUIRE(windows.ok());
  REQUIRE(windows->size() == 1);
  const core::RecognizedWindow& window = windows->front();
  std::map<std::string, double> of_label;  // labels have three clips each
  double all = 0;
  const double best = window.clips.front().log_probability;
  for (const core::ClipScore& score : window.clips) {
    of_label[model.clips()[score.clip].label()] += std::exp(score.log_probability - best);
    all += std::exp(score.log_probability - best);
  }
  for (const core::LabelScore& label : window.labels) {
    CHECK(label.probability == Approx(of_label[label.label] / all));
  }
  const int layer = model.layer_count();
  const auto scaled = core::ScaledObservation(model, clip);
  REQUIRE(scaled.ok());
  core::EmissionMatrix density(24, model.tree().node_count(layer));
  for (Eigen::Index t = 0; t < 24; ++t) {
    for (int n = 0; n < model.tree().node_count(layer); ++n) {
      density(t, n) =
          model.gaussians().LogDensity(model.tree().branch(layer, n), scaled->row(t).data());
    }
  }
  CHECK(
      window.familiarity ==
      model.familiarity().Rank(layer, core::FamiliarityScore(model.global_graph(layer), density)));
}

TEST_CASE("Recognize: a model without a metric uses kPaper", "[core][recognition]") {
  core::ModelParts parts = SmallModel(4, 120, 3, 8, 31).parts();
  parts.metric = {};
  const auto model = core::Model::Create(std::move(parts));
  REQUIRE(model.ok());
  const core::StateSequence clip = Clip(*model, 2, 120);
  core::RecognizeOptions options;
  const auto best = core::Recognize(*model, clip, options);
  options.method = core::Method::kPaper;
  const auto paper = core::Recognize(*model, clip, options);
  REQUIRE((best.ok() && paper.ok()));
  for (std::size_t w = 0; w < paper->size(); ++w) {
    CHECK((*best)[w].familiarity == (*paper)[w].familiarity);
    for (std::size_t l = 0; l < 2; ++l) {
      CHECK((*best)[w].labels[l].probability == (*paper)[w].labels[l].probability);
    }
  }
}

TEST_CASE("Recognize: windows move by the hop, and each equals a separate query",
          "[core][recognition]") {
  const core::Model model = SmallModel(4, 120, 3, 8, 31);
  const core::StateSequence clip = Clip(model, 1, 120);
  const auto method = GENERATE(core::Method::kPaper, core::Method::kBest);
  core::RecognizeOptions options;
  options.method = method;
  options.window_seconds = 0.5;
  options.hop_seconds = 0.25;
  const auto windows = core::Recognize(model, clip, options);
  REQUIRE(windows.ok());
  REQUIRE(windows->size() == 7);  // 120 frames, windows of 30 every 15
  for (std::size_t w = 0; w < windows->size(); ++w) {
    const core::RecognizedWindow& window = (*windows)[w];
    CHECK(window.start_seconds == Approx(0.25 * static_cast<double>(w)));
    CHECK(window.end_seconds == Approx(window.start_seconds + 0.5));
    core::StateSequence alone = clip;
    alone.states = clip.states.middleRows(15 * static_cast<Eigen::Index>(w), 30).eval();
    alone.root_path = clip.root_path.middleRows(15 * static_cast<Eigen::Index>(w), 30).eval();
    const auto single = core::Recognize(model, alone, options);
    REQUIRE(single.ok());
    REQUIRE(single->size() == 1);
    for (std::size_t c = 0; c < window.clips.size(); ++c) {
      CHECK(window.clips[c].clip == single->front().clips[c].clip);
      const double alone_log = single->front().clips[c].log_probability;
      if (method == core::Method::kPaper) {
        CHECK(window.clips[c].log_probability == Approx(alone_log).epsilon(1e-9));
      } else {  // single precision, projected with other frames
        CHECK(window.clips[c].log_probability == Approx(alone_log).epsilon(1e-5).margin(0.01));
      }
    }
  }
}

TEST_CASE("Recognize: a whole observation or a short one is one window", "[core][recognition]") {
  const core::Model model = SmallModel(2, 100, 2, 8, 31);
  core::RecognizeOptions options;
  options.whole = true;
  const auto whole = core::Recognize(model, Clip(model, 0, 100), options);
  REQUIRE(whole.ok());
  REQUIRE(whole->size() == 1);
  CHECK(whole->front().end_seconds == Approx(100 / 60.0));
  const auto brief = core::Recognize(model, Clip(model, 0, 5), {});
  REQUIRE(brief.ok());
  REQUIRE(brief->size() == 1);
  CHECK(brief->front().end_seconds == Approx(5 / 60.0));
}

TEST_CASE("Recognize: log probabilities equal eq. 7 on every layer", "[core][recognition]") {
  const core::Model model = SmallModel(3, 90, 2, 8, 31);
  const core::StateSequence clip = Clip(model, 2, 12);
  const auto scaled = core::ScaledObservation(model, clip);
  REQUIRE(scaled.ok());
  for (int layer = 1; layer <= model.layer_count(); ++layer) {
    core::RecognizeOptions options;
    options.method = core::Method::kPaper;
    options.layer = layer;
    options.whole = true;
    const auto windows = core::Recognize(model, clip, options);
    REQUIRE(windows.ok());
    CHECK(windows->front().layer == layer);
    core::EmissionMatrix posterior(12, model.tree().node_count(layer));
    for (Eigen::Index t = 0; t < 12; ++t) {
      for (int n = 0; n < model.tree().node_count(layer); ++n) {
        posterior(t, n) = std::exp(
            model.gaussians().LogDensity(model.tree().branch(layer, n), scaled->row(t).data()));
      }
      posterior.row(t) /= posterior.row(t).sum();  // eq. 8
    }
    for (const core::ClipScore& score : windows->front().clips) {
      const core::ClipGraph graph = *model.clip_graph(layer, score.clip);
      core::EmissionMatrix emission(12, static_cast<Eigen::Index>(graph.nodes.size()));
      for (Eigen::Index s = 0; s < emission.cols(); ++s) {
        emission.col(s) = posterior.col(graph.nodes[static_cast<std::size_t>(s)]).array().log();
      }
      CHECK(score.log_probability ==
            Approx(core::LogGeneration(graph.transitions, emission, 1e-6)).epsilon(1e-6));
    }
  }
}

TEST_CASE("Recognize: the sum of the best paths approaches the exact sum", "[core][recognition]") {
  const core::Model model = SmallModel(2, 80, 2, 8, 31);
  const core::StateSequence clip = Clip(model, 0, 6);
  core::RecognizeOptions options;
  options.method = core::Method::kPaper;
  options.whole = true;
  const auto exact = core::Recognize(model, clip, options);
  REQUIRE(exact.ok());
  options.generation = core::Generation::kTopPaths;
  double before = -std::numeric_limits<double>::infinity();
  for (const int paths : {1, 2, 5, 20, 100}) {
    options.path_count = paths;
    const auto top = core::Recognize(model, clip, options);
    REQUIRE(top.ok());
    const double now = top->front().clips.front().log_probability;
    CHECK(now >= before - 1e-9);
    CHECK(now <= exact->front().clips.front().log_probability + 1e-9);
    before = now;
  }
  CHECK(before == Approx(exact->front().clips.front().log_probability).margin(0.05));
}

TEST_CASE("Recognize: motion unlike the stored motion is unfamiliar", "[core][recognition]") {
  const core::Model model = SmallModel(6, 240, 3, 8, 31);
  core::StateSequence odd = Clip(model, 0, 60);
  const auto known = core::Recognize(model, odd, {});
  odd.states.array() += 5;
  const auto unknown = core::Recognize(model, odd, {});
  REQUIRE((known.ok() && unknown.ok()));
  for (const auto& window : *known) CHECK(window.familiarity > 0.02);
  for (const auto& window : *unknown) CHECK(window.familiarity == 0);
}

TEST_CASE("Recognize: ignores missing markers", "[core][recognition]") {
  const core::Model model = SmallModel(4, 240, 5, 8, 31);
  core::StateSequence clip = Clip(model, 1, 240);
  for (Eigen::Index t = 0; t < clip.states.rows(); ++t) {
    clip.states.row(t).segment<6>(6 * (t % 5)).setConstant(std::nanf(""));
  }
  const auto windows = core::Recognize(model, clip, {});
  REQUIRE(windows.ok());
  for (const auto& window : *windows) {
    CHECK(window.labels.front().label == "b");
    CHECK(std::isfinite(window.clips.front().log_probability));
  }
}

TEST_CASE("Recognize: rejects invalid options and observations, naming the field",
          "[core][recognition]") {
  const core::Model model = SmallModel(2, 60, 2, 8, 31);
  const core::StateSequence clip = Clip(model, 0, 30);
  const auto message = [&](const core::StateSequence& observation,
                           const std::function<void(core::RecognizeOptions&)>& change) {
    core::RecognizeOptions options;
    change(options);
    const auto result = core::Recognize(model, observation, options);
    CHECK_FALSE(result.ok());
    return std::string(result.status().message());
  };
  using Catch::Matchers::Contains;
  CHECK_THAT(message(clip, [](auto& o) { o.window_seconds = 0; }), Contains("window_seconds"));
  CHECK_THAT(message(clip, [](auto& o) { o.window_seconds = std::nan(""); }),
             Contains("window_seconds"));
  CHECK_THAT(message(clip, [](auto& o) { o.hop_seconds = -1; }), Contains("hop_seconds"));
  CHECK_THAT(message(clip, [](auto& o) { o.transition_floor = 2; }), Contains("transition_floor"));
  CHECK_THAT(message(clip, [](auto& o) { o.path_count = 0; }), Contains("path_count"));
  CHECK_THAT(message(clip, [](auto& o) { o.layer = -1; }), Contains("layer"));
  core::StateSequence wrong = clip;
  wrong.frame_rate_hz = 30;
  CHECK_THAT(message(wrong, [](auto&) {}), Contains("frame rate of"));
  wrong = clip;
  wrong.states.conservativeResize(Eigen::NoChange, 6);
  CHECK_THAT(message(wrong, [](auto&) {}), Contains("numbers"));
  wrong = clip;
  wrong.states(3, 3) = std::numeric_limits<float>::infinity();
  CHECK_THAT(message(wrong, [](auto&) {}), Contains("finite numbers"));
  wrong.states.resize(0, wrong.states.cols());
  wrong.root_path.resize(0, 3);
  CHECK_THAT(message(wrong, [](auto&) {}), Contains("at least one frame"));
  CHECK(core::Recognize(model, clip, {}, [] { return true; }).status().code() ==
        absl::StatusCode::kCancelled);
}

}  // namespace motiondb::tests::recognize_test
