#include "core/prediction/predict.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/prediction/forecast.h"
#include "core/recognition/recognize.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::predict_test {
namespace {

core::StateSequence Cut(const core::StateSequence& clip, int first, int count) {
  core::StateSequence cut = clip;
  cut.states = clip.states.middleRows(first, count).eval();
  cut.root_path = clip.root_path.middleRows(first, count).eval();
  return cut;
}

// One periodic clip (period 1 s): 10 s of four markers on circles.
std::vector<core::BuildInput> PeriodicClip(const core::MarkerSet& set) {
  auto inputs = WanderingClips(1, 600, set, 43);
  core::StateSequence& clip = inputs[0].states;
  for (Eigen::Index t = 0; t < 600; ++t) {
    for (Eigen::Index d = 0; d < clip.states.cols(); ++d) {
      const double phase = 2 * M_PI * (static_cast<double>(t) / 60 + 0.13 * static_cast<double>(d));
      const bool velocity = d % 6 >= 3;
      clip.states(t, d) =
          static_cast<float>(velocity ? 2 * M_PI * std::cos(phase) : std::sin(phase));
    }
  }
  return inputs;
}

}  // namespace

TEST_CASE("Predict: uses nothing after the moment", "[core][prediction]") {
  const core::Model model = SmallModel(4, 200, 4, 8, 41);
  core::StateSequence clip = WanderingClips(4, 200, model.marker_set(), 41)[1].states;
  core::PredictOptions options;
  options.at_seconds = 1.0;
  const auto before = core::Predict(model, clip, options);
  REQUIRE(before.ok());
  clip.states.bottomRows(139).setConstant(7);
  clip.root_path.bottomRows(139).setConstant(3);
  const auto after = core::Predict(model, clip, options);
  REQUIRE(after.ok());
  CHECK(before->state.node == after->state.node);
  for (std::size_t h = 0; h < before->horizons.size(); ++h) {
    CHECK(before->horizons[h].marker_positions_m == after->horizons[h].marker_positions_m);
  }
}

TEST_CASE("Predict: next nodes are the graph's transitions to other nodes, with their clips",
          "[core][prediction]") {
  const core::Model model = SmallModel(4, 200, 4, 8, 41);
  const auto clip = WanderingClips(4, 200, model.marker_set(), 41)[0].states;
  for (const double at : {0.5, 1.0, 2.0, 3.0}) {
    core::PredictOptions options;
    options.at_seconds = at;
    const auto prediction = core::Predict(model, clip, options);
    REQUIRE(prediction.ok());
    CHECK(prediction->at_seconds == Approx(at));
    double sum = 0;
    for (const core::NextNode& next : prediction->next_nodes) {
      CHECK(next.node != prediction->state.node);
      CHECK(next.probability > 0);
      CHECK_FALSE(next.clips.empty());
      sum += next.probability;
    }
    CHECK(sum <= 1 + 1e-9);
    CHECK(sum > 0.9);
    if (prediction->state.probability < 0.999) continue;
    // The node is certain: eq. 6 without the transition to itself.
    const auto& graph = model.global_graph(prediction->layer);
    const int from = prediction->state.node;
    for (const core::NextNode& next : prediction->next_nodes) {
      const double expected = graph.count(from, next.node) /
                              (static_cast<double>(graph.row_sum(from)) - graph.count(from, from));
      CHECK(next.probability == Approx(expected).margin(0.01));
    }
  }
}

TEST_CASE("Predict: finds the future of a stored clip, in the observation's world and size",
          "[core][prediction]") {
  const core::MarkerSet set = SmallMarkerSet(4);
  const auto built = core::BuildModel({}, set, PeriodicClip(set), core::RunSerially, {});
  REQUIRE(built.ok());
  const core::Model& model = *built;
  const core::StateSequence clip = PeriodicClip(set)[0].states;
  const core::FrameMatrix world = core::WorldPositions(clip);
  core::PredictOptions options;
  options.horizon_seconds = {0, 0.1, 0.2};
  const auto prediction = core::Predict(model, Cut(clip, 0, 151), options);
  REQUIRE(prediction.ok());
  CHECK(prediction->at_seconds == Approx(2.5));
  CHECK((prediction->horizons[0].marker_positions_m.transpose() - world.row(150)).norm() < 1e-4);
  for (const int h : {1, 2}) {
    const auto& predicted = prediction->horizons[h].marker_positions_m;
    const double error = (predicted.transpose() - world.row(150 + 6 * h)).norm();
    const double still = (world.row(150) - world.row(150 + 6 * h)).norm();
    CHECK(error < 0.1 * still);
    CHECK(prediction->horizons[h].confidence >= 0);
    CHECK(prediction->horizons[h].confidence <= 1);
  }

  // The observation is moved, rotated and scaled: the prediction must follow.
  core::StateSequence moved = Cut(clip, 0, 151);
  const double turn = 1.2;
  const double c = std::cos(turn);
  const double s = std::sin(turn);
  moved.leg_length_m *= 1.5;
  for (Eigen::Index t = 0; t < moved.root_path.rows(); ++t) {
    const double x = 1.5 * moved.root_path(t, 0);
    const double y = 1.5 * moved.root_path(t, 1);
    moved.root_path.row(t) << 4 + c * x - s * y, -2 + s * x + c * y, moved.root_path(t, 2) + turn;
  }
  const auto elsewhere = core::Predict(model, moved, options);
  REQUIRE(elsewhere.ok());
  for (std::size_t h = 0; h < 3; ++h) {
    const auto& from = prediction->horizons[h].marker_positions_m;
    const auto& to = elsewhere->horizons[h].marker_positions_m;
    for (Eigen::Index m = 0; m < from.size() / 3; ++m) {
      const double x = 1.5 * from[3 * m];
      const double y = 1.5 * from[3 * m + 1];
      CHECK(to[3 * m] == Approx(4 + c * x - s * y).margin(1e-3));
      CHECK(to[3 * m + 1] == Approx(-2 + s * x + c * y).margin(1e-3));
      CHECK(to[3 * m + 2] == Approx(1.5 * from[3 * m + 2]).margin(1e-3));
    }
  }
}

TEST_CASE("Predict: predicts missing markers", "[core][prediction]") {
  const core::Model model = SmallModel(2, 200, 4, 8, 41);
  core::StateSequence clip = WanderingClips(2, 200, model.marker_set(), 41)[0].states;
  clip.states.middleCols<6>(12).setConstant(std::nanf(""));
  const auto prediction = core::Predict(model, clip, {});
  REQUIRE(prediction.ok());
  for (const auto& horizon : prediction->horizons) {
    CHECK(horizon.marker_positions_m.allFinite());
  }
}

TEST_CASE("PredictFrames: equals the horizons of Predict", "[core][prediction]") {
  const core::Model model = SmallModel(4, 200, 4, 8, 41);
  const core::StateSequence whole = WanderingClips(4, 200, model.marker_set(), 41)[1].states;
  core::StateSequence gappy = whole;
  gappy.states.block(100, 6, 30, 6).setConstant(std::nanf(""));
  for (const core::StateSequence& clip : {whole, gappy}) {
    for (const int layer : {0, 2}) {
      for (const core::Method method : {core::Method::kBest, core::Method::kPaper}) {
        core::PredictOptions options;
        options.method = method;
        options.layer = layer;
        options.at_seconds = 2;
        const auto prediction = core::Predict(model, clip, options);
        const auto frames = core::PredictFrames(model, clip, options);
        REQUIRE(prediction.ok());
        REQUIRE(frames.ok());
        REQUIRE(frames->size() == prediction->horizons.size());
        for (std::size_t h = 0; h < frames->size(); ++h) {
          const core::PredictedFrame& expected = prediction->horizons[h];
          CHECK((*frames)[h].seconds == expected.seconds);
          CHECK((*frames)[h].marker_positions_m == expected.marker_positions_m);
          CHECK((*frames)[h].confidence == expected.confidence);
          CHECK((*frames)[h].expected_error_m == expected.expected_error_m);
        }
      }
    }
  }
  core::PredictOptions missing;
  missing.layer = model.layer_count() + 1;
  CHECK(absl::IsOutOfRange(core::PredictFrames(model, whole, missing).status()));
}

TEST_CASE("Predict: reports horizons that stored motion does not reach, without confidence",
          "[core][prediction]") {
  const core::Model model = SmallModel(4, 60, 2, 8, 1);
  const core::StateSequence clip = WanderingClips(4, 60, SmallMarkerSet(2), 1)[0].states;
  core::PredictOptions options;
  options.at_seconds = 0.5;
  options.horizon_seconds = {0.1, 0.4, 5};
  const auto prediction = core::Predict(model, clip, options);
  REQUIRE(prediction.ok());
  for (const core::PredictedFrame& frame : prediction->horizons) {
    CHECK(frame.extrapolated == (frame.seconds > 1));
    CHECK(frame.confidence.has_value() == !frame.extrapolated);
    CHECK_FALSE(frame.expected_error_m.has_value());  // not calibrated
  }
}

TEST_CASE("Predict: the unknown probability is that of the last 0.4 s", "[core][prediction]") {
  core::Model model = SmallModel(4, 60, 2, 8, 1);
  const core::StateSequence clip = WanderingClips(4, 60, SmallMarkerSet(2), 1)[0].states;
  core::PredictOptions options;
  options.at_seconds = 0.5;
  const auto plain = core::Predict(model, clip, options);
  REQUIRE(plain.ok());
  CHECK_FALSE(plain->unknown_probability.has_value());

  core::RecognitionCalibration calibration;
  calibration.window.unknown = core::UnknownModel{.intercept = 1, .weights = {0.5, -0.5}};
  calibration.unknown = core::UnknownCalibration::kFitted;
  model.set_recognition(calibration);
  for (const double history : {0.1, 0.4, 0.5}) {
    options.history_seconds = history;
    const auto prediction = core::Predict(model, clip, options);
    const auto windows = core::Recognize(
        model, core::PastAt(clip, 30, static_cast<int>(std::lround(60 * std::min(0.4, history)))),
        {});
    REQUIRE(prediction.ok());
    REQUIRE(windows.ok());
    REQUIRE(prediction->unknown_probability.has_value());
    CHECK(prediction->unknown_probability == windows->front().unknown_probability);
  }
  options.method = core::Method::kPaper;
  CHECK_FALSE(core::Predict(model, clip, options)->unknown_probability.has_value());
}

TEST_CASE("Predict: kPaper predicts node means along the graph", "[core][prediction]") {
  const core::MarkerSet set = SmallMarkerSet(4);
  const auto built = core::BuildModel({}, set, PeriodicClip(set), core::RunSerially, {});
  REQUIRE(built.ok());
  const core::StateSequence clip = PeriodicClip(set)[0].states;
  core::PredictOptions options;
  options.method = core::Method::kPaper;
  options.horizon_seconds = {0.5, 0.1, 0};  // in any order
  const auto prediction = core::Predict(*built, Cut(clip, 0, 151), options);
  REQUIRE(prediction.ok());
  REQUIRE(prediction->horizons.size() == 3);
  const core::FrameMatrix world = core::WorldPositions(clip);
  for (int h = 0; h < 3; ++h) {
    CHECK(prediction->horizons[h].seconds == options.horizon_seconds[h]);
    CHECK_FALSE(prediction->horizons[h].confidence.has_value());
  }
  // Node means only approximate the positions.
  const auto& now = prediction->horizons[2].marker_positions_m;
  CHECK((now.transpose() - world.row(150)).norm() < 1);
}

TEST_CASE("Predict: a left-out clip is not an example", "[core][prediction]") {
  const core::MarkerSet set = SmallMarkerSet(4);
  auto inputs = PeriodicClip(set);
  inputs.push_back(WanderingClips(2, 300, set, 4)[1]);
  const auto built = core::BuildModel({}, set, std::move(inputs), core::RunSerially, {});
  REQUIRE(built.ok());
  const core::StateSequence clip = Cut(PeriodicClip(set)[0].states, 0, 151);
  const auto error = [&](core::FrameRange without) {
    core::PredictOptions options;
    options.horizon_seconds = {0.3};
    options.without = without;
    const auto prediction = core::Predict(*built, clip, options);
    REQUIRE(prediction.ok());
    return (prediction->horizons[0].marker_positions_m.transpose() -
            core::WorldPositions(PeriodicClip(set)[0].states).row(168))
        .norm();
  };
  CHECK(error({0, 600}) > 3 * error({}));
}

TEST_CASE("Forecaster: uses examples whose clips continue until the horizon",
          "[core][prediction]") {
  const core::MarkerSet set = SmallMarkerSet(4);
  const auto built = core::BuildModel({}, set, PeriodicClip(set), core::RunSerially, {});
  REQUIRE(built.ok());
  const core::StateSequence past = Cut(PeriodicClip(set)[0].states, 100, 51);
  core::Forecaster at_end(*built, past, {{599, false}, {595, false}});
  CHECK(at_end.At(0.05).evidence.variance < 1);
  CHECK(at_end.At(0.2).evidence.variance == 1);
  core::Forecaster nothing(*built, past, {});
  const core::Forecast forecast = nothing.At(0.5);
  CHECK(forecast.evidence.variance == 1);
  CHECK(forecast.positions.allFinite());
}

TEST_CASE("Predict: rejects invalid options, naming the field", "[core][prediction]") {
  const core::Model model = SmallModel(2, 100, 2, 8, 41);
  const auto clip = WanderingClips(1, 60, model.marker_set(), 41)[0].states;
  const auto message = [&](const std::function<void(core::PredictOptions&)>& change) {
    core::PredictOptions options;
    change(options);
    const auto result = core::Predict(model, clip, options);
    CHECK_FALSE(result.ok());
    return std::string(result.status().message());
  };
  using Catch::Matchers::Contains;
  CHECK_THAT(message([](auto& o) { o.at_seconds = -0.1; }), Contains("at_seconds"));
  CHECK_THAT(message([](auto& o) { o.at_seconds = 9; }), Contains("at_seconds"));
  CHECK_THAT(message([](auto& o) { o.at_seconds = std::nan(""); }), Contains("at_seconds"));
  CHECK_THAT(message([](auto& o) { o.history_seconds = 0; }), Contains("history_seconds"));
  CHECK_THAT(message([](auto& o) {
               o.horizon_seconds = {0.1, -1};
             }),
             Contains("horizon_seconds[1]"));
  CHECK_THAT(message([](auto& o) { o.transition_floor = -1; }), Contains("transition_floor"));
}

}  // namespace motiondb::tests::predict_test
