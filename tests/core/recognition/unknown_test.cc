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

core::WindowAlignment AlignmentOf(int frames, double noise = 0) {
  return {.frames = frames, .noise = noise};
}

core::UnknownModel ModelOfUnknown() {
  return {.intercept = -1, .weights = {1, -0.5}, .typical_log_distance = 3, .labels = {{"a", 2.5}}};
}

std::vector<core::RecognizedWindow> WindowsOf(const core::Model& model,
                                              const core::StateSequence& states,
                                              const core::RecognizeOptions& options = {}) {
  auto windows = core::Recognize(model, states, options);
  REQUIRE(windows.ok());
  return *std::move(windows);
}

}  // namespace

TEST_CASE("FindBestLabel: distance of the best label, and its lead", "[core][recognition]") {
  const core::BestLabel best = core::FindBestLabel({-40, -20, -60}, AlignmentOf(10));
  CHECK(best.label == 1);
  CHECK(best.log_distance == Approx(std::log(6 * 2)));
  CHECK(best.lead == Approx(std::log(2)));
  CHECK(core::FindBestLabel({-20, -20}, AlignmentOf(10)).lead == 0);
  const auto features = core::UnknownFeatures(best, 2);
  CHECK(features[0] == Approx(std::log(12) - 2));
  CHECK(features[1] == best.lead);
}

TEST_CASE("FindBestLabel: finite for labels without clips, a single label, and equal motion",
          "[core][recognition]") {
  CHECK(core::FindBestLabel({kNone, -20, -60}, AlignmentOf(10)).lead == Approx(std::log(3)));
  CHECK(core::FindBestLabel({kNone, -20}, AlignmentOf(10)).lead == 0);
  CHECK(core::FindBestLabel({-20}, AlignmentOf(10)).lead == 0);
  const core::BestLabel equal = core::FindBestLabel({0.5, -6}, AlignmentOf(1));
  CHECK(equal.log_distance == Approx(std::log(1e-3)));
  CHECK(equal.lead == Approx(std::log(6 * 6 / 1e-3)));
}

TEST_CASE("FindBestLabel: noise that adds to all squared distances has no effect",
          "[core][recognition]") {
  const auto best_at = [](double noise) {
    const double added = 10 * noise / 6;  // evidence of 10 frames
    return core::FindBestLabel({-40 - added, -20 - added, -60 - added}, AlignmentOf(10, noise));
  };
  const core::BestLabel clean = best_at(0);
  const core::BestLabel noisy = best_at(100);
  CHECK(noisy.label == clean.label);
  CHECK(noisy.log_distance == Approx(clean.log_distance));
  CHECK(noisy.lead == Approx(clean.lead));
  // More noise than distance: all of the motion is explained, up to the error of the noise.
  const core::BestLabel all = core::FindBestLabel({-20, -30}, AlignmentOf(10, 100));
  CHECK(all.log_distance == Approx(std::log(2)));
  CHECK(all.lead == 0);
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
