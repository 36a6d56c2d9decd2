#include "core/recognition/unknown.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/model/model.h"
#include "core/recognition/recognize.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::unknown_test {
namespace {

constexpr double kNone = -std::numeric_limits<double>::infinity();

core::WindowAlignment AlignmentOf(int frames, double energy, double noise = 0) {
  return {.frames = frames, .energy = energy, .noise = noise};
}

core::UnknownModel ModelOfUnknown() {
  return {.intercept = -1,
          .weights = {1, -0.5, -0.25},
          .typical_mean = -10,
          .typical_deviation = 5,
          .fits = {{"a", -2, 1}}};
}

std::vector<core::RecognizedWindow> WindowsOf(const core::Model& model,
                                              const core::StateSequence& states,
                                              const core::RecognizeOptions& options = {}) {
  auto windows = core::Recognize(model, states, options);
  REQUIRE(windows.ok());
  return *std::move(windows);
}

}  // namespace

TEST_CASE("FindBestLabel: fit, odds and the unexplained part of the best label",
          "[core][recognition]") {
  const core::BestLabel best = core::FindBestLabel({-40, -20, -60}, AlignmentOf(10, 24), {0.5, 1});
  CHECK(best.label == 1);
  CHECK(best.fit == Approx(-2));
  CHECK(best.unexplained == Approx(std::log(6 * 2 / 24.0)));
  CHECK(best.log_odds == Approx(-10 - std::log(std::exp(-20.0) + std::exp(-30.0))));
}

TEST_CASE("FindBestLabel: finite for labels without clips, a single label, and equal motion",
          "[core][recognition]") {
  CHECK(core::FindBestLabel({kNone, -20, -60}, AlignmentOf(10, 24), {0.5, 1}).log_odds ==
        Approx(20));
  CHECK(core::FindBestLabel({kNone, -20}, AlignmentOf(10, 24), {0.5, 1}).log_odds == 0);
  CHECK(core::FindBestLabel({-20}, AlignmentOf(10, 24), {0.5, 1}).log_odds == 0);
  CHECK(std::isfinite(core::FindBestLabel({0.5}, AlignmentOf(1, 0), {1, 1}).unexplained));
}

TEST_CASE("FindBestLabel: noise that adds to all squared distances has no effect",
          "[core][recognition]") {
  const auto best_at = [](double noise) {
    const double added = 10 * noise / 6;  // evidence of 10 frames
    return core::FindBestLabel({-40 - added, -20 - added, -60 - added},
                               AlignmentOf(10, 24 + noise, noise), {0.5, 1});
  };
  const core::BestLabel clean = best_at(0);
  const core::BestLabel noisy = best_at(100);
  CHECK(noisy.label == clean.label);
  CHECK(noisy.fit == Approx(clean.fit));
  CHECK(noisy.unexplained == Approx(clean.unexplained));
  CHECK(noisy.log_odds == Approx(clean.log_odds));
  // More noise than distance: all of the motion is explained, up to the error of the noise.
  const core::BestLabel all = core::FindBestLabel({-20}, AlignmentOf(10, 124, 100), {0.5, 1});
  CHECK(all.fit == Approx(-2.0 / 6));
  CHECK(all.unexplained == Approx(std::log(2.0 / 24)));
}

TEST_CASE("UnknownFeatures: bounded", "[core][recognition]") {
  const auto features = core::UnknownFeatures({0, -1e9, 0.5, 1e9}, 0, 1);
  CHECK(features[0] == 0.5);
  CHECK(features[1] == Approx(-6));
  CHECK(features[2] == Approx(4));
}

TEST_CASE("Recognize: labels and unknown sum to 1; without a fitted model the labels alone",
          "[core][recognition]") {
  core::Model model = SmallModel(4, 60, 2, 8, 1);
  const std::vector<core::BuildInput> clips = WanderingClips(4, 60, SmallMarkerSet(2), 1);
  const auto sum = [](const core::RecognizedWindow& window) {
    double labels = 0;
    for (const core::LabelScore& score : window.labels) labels += score.probability;
    return labels;
  };
  for (const auto& window : WindowsOf(model, clips[0].states)) {
    CHECK_FALSE(window.unknown_probability.has_value());
    CHECK(sum(window) == Approx(1));
  }
  const auto plain = WindowsOf(model, clips[0].states);
  core::RecognitionCalibration calibration;
  calibration.window.unknown = calibration.whole.unknown = ModelOfUnknown();
  calibration.unknown = core::UnknownCalibration::kFitted;
  model.set_recognition(calibration);
  for (const bool whole : {false, true}) {
    core::RecognizeOptions options;
    options.whole = whole;
    for (const auto& window : WindowsOf(model, clips[0].states, options)) {
      REQUIRE(window.unknown_probability.has_value());
      CHECK(*window.unknown_probability > 0);
      CHECK(*window.unknown_probability < 1);
      CHECK(sum(window) + *window.unknown_probability == Approx(1));
    }
    options.method = core::Method::kPaper;
    for (const auto& window : WindowsOf(model, clips[0].states, options)) {
      CHECK_FALSE(window.unknown_probability.has_value());
    }
  }
  // The labels keep their ratios.
  const auto with = WindowsOf(model, clips[0].states);
  REQUIRE(with.size() == plain.size());
  for (std::size_t w = 0; w < with.size(); ++w) {
    CHECK(with[w].labels[0].label == plain[w].labels[0].label);
    CHECK(with[w].labels[0].probability ==
          Approx(plain[w].labels[0].probability * (1 - *with[w].unknown_probability)));
  }
}

TEST_CASE("Recognize: motion far from all clips is more probably unknown", "[core][recognition]") {
  core::Model model = SmallModel(4, 60, 2, 8, 1);
  core::RecognitionCalibration calibration;
  calibration.window.unknown = calibration.whole.unknown = ModelOfUnknown();
  calibration.unknown = core::UnknownCalibration::kFitted;
  model.set_recognition(calibration);
  const std::vector<core::BuildInput> clips = WanderingClips(4, 60, SmallMarkerSet(2), 1);
  core::StateSequence odd = clips[0].states;
  odd.states.array() += 20;
  const double stored = *WindowsOf(model, clips[0].states).front().unknown_probability;
  const double far = *WindowsOf(model, odd).front().unknown_probability;
  CHECK(stored < 0.3);
  CHECK(far > stored + 0.3);
}

}  // namespace motiondb::tests::unknown_test
