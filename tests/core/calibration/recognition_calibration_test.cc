#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <random>
#include <string>

#include "core/calibration/calibrate.h"
#include "core/model/label_units.h"
#include "core/recognition/recognize.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::recognition_calibration_test {
namespace {

// Clips of three labels so similar that windows are sometimes confused.
std::vector<core::BuildInput> AlikeClips(int clips, const core::MarkerSet& set, unsigned seed) {
  std::vector<core::BuildInput> inputs = WanderingClips(clips, 96, set, 77);
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  for (std::size_t c = 0; c < inputs.size(); ++c) {
    core::FrameMatrix& states = inputs[c].states.states;
    states = WanderingStates(96, set.dimension_count(), 77);
    const auto label = c % 3;
    inputs[c].labels = std::string(1, static_cast<char>('a' + label));
    inputs[c].subject = "subject " + std::to_string(c % 4);
    states.col(static_cast<Eigen::Index>(label)).array() += 1;
    for (Eigen::Index d = 0; d < states.cols(); ++d) {
      float drift = 0.7F * normal(random);
      for (Eigen::Index t = 0; t < states.rows(); ++t) {
        drift += 0.15F * (0.7F * normal(random) - 0.3F * drift);
        states(t, d) += drift;
      }
    }
  }
  return inputs;
}

core::Model ModelOf(std::vector<core::BuildInput> inputs, const core::MarkerSet& set) {
  core::BuildSettings settings;
  settings.frame_rate_hz = inputs.front().states.frame_rate_hz;
  auto model = core::BuildModel(settings, set, std::move(inputs), core::RunSerially, {});
  INFO(model.status());
  REQUIRE(model.ok());
  return *std::move(model);
}

struct Reliability {
  double loss = 0;   // mean negative log probability of the correct label
  double error = 0;  // expected calibration error, 10 bins
};

Reliability Judge(const core::Model& model, const std::vector<core::BuildInput>& inputs,
                  bool whole) {
  std::array<double, 10> surplus{};
  double loss = 0;
  double count = 0;
  for (const core::BuildInput& input : inputs) {
    core::RecognizeOptions options;
    options.whole = whole;
    const auto windows = core::Recognize(model, input.states, options);
    REQUIRE(windows.ok());
    for (const auto& window : *windows) {
      // All inputs are known: probabilities given that.
      const double known = 1 - window.unknown_probability.value_or(0);
      for (const auto& label : window.labels) {
        if (label.label == input.label())
          loss -= std::log(std::max(label.probability / known, 1e-300));
      }
      const auto& first = window.labels.front();
      const double probability = first.probability / known;
      const int bin = std::min(9, static_cast<int>(10 * probability));
      surplus[static_cast<std::size_t>(bin)] +=
          probability - (first.label == input.label() ? 1 : 0);
      ++count;
    }
  }
  double error = 0;
  for (const double bin : surplus) error += std::abs(bin);
  return {loss / count, error / count};
}

}  // namespace

TEST_CASE("Calibrate: probabilities of unseen windows equal frequencies", "[core][calibration]") {
  const core::MarkerSet set = SmallMarkerSet(4);
  core::Model model = ModelOf(AlikeClips(36, set, 1), set);
  const auto unseen = AlikeClips(36, set, 2);
  core::RecognitionCalibration plain;
  plain.window.weight = plain.whole.weight = {1, 1};  // as if frames were independent
  model.set_recognition(plain);
  const Reliability before = Judge(model, unseen, false);
  REQUIRE(core::Calibrate(model, core::RunSerially, {}).ok());
  const Reliability after = Judge(model, unseen, false);
  CHECK(after.loss < before.loss);
  CHECK(after.error < before.error);
  CHECK(after.error < 0.1);
}

TEST_CASE("Calibrate: held-out windows have uniform ranks, unfamiliar ones low ranks",
          "[core][calibration]") {
  const core::MarkerSet set = SmallMarkerSet(4);
  core::Model model = ModelOf(AlikeClips(36, set, 1), set);
  REQUIRE(core::Calibrate(model, core::RunSerially, {}).ok());
  CHECK(std::is_sorted(model.recognition().window.familiarity.begin(),
                       model.recognition().window.familiarity.end()));
  CHECK(model.recognition().whole.familiarity.size() == 36 * 6);
  for (const bool whole : {false, true}) {
    core::RecognizeOptions options;
    options.whole = whole;
    double sum = 0;
    double count = 0;
    for (const core::BuildInput& input : AlikeClips(36, set, 2)) {
      const auto windows = core::Recognize(model, input.states, options);
      REQUIRE(windows.ok());
      for (const auto& window : *windows) {
        sum += window.familiarity;
        ++count;
      }
    }
    CHECK(sum / count > 0.25);
    // The velocities made up here are not those of the positions, so that a beginning's last frame,
    // whose velocity is computed, looks odd: whole observations rank above beginnings.
    if (!whole) CHECK(sum / count < 0.75);
    core::StateSequence odd = AlikeClips(1, set, 2).front().states;
    odd.states.array() += 20;
    CHECK(core::Recognize(model, odd, options)->front().familiarity == 0);
  }
}

TEST_CASE("Calibrate: independent of the order of work; no change if cancelled",
          "[core][calibration]") {
  const core::MarkerSet set = SmallMarkerSet(3);
  core::Model model = ModelOf(AlikeClips(10, set, 1), set);
  core::Model again = ModelOf(AlikeClips(10, set, 1), set);
  const core::ParallelFor backwards = [](int count, const std::function<void(int)>& body) {
    for (int i = count - 1; i >= 0; --i) body(i);
  };
  CHECK(core::Calibrate(again, backwards, [](double, std::string_view) { return false; }).code() ==
        absl::StatusCode::kCancelled);
  CHECK(again.recognition().window.familiarity.empty());
  double last = -1;
  REQUIRE(core::Calibrate(model, core::RunSerially, {}).ok());
  REQUIRE(core::Calibrate(again, backwards, [&](double fraction, std::string_view) {
            CHECK(fraction > last);
            last = fraction;
            return fraction <= 1;
          }).ok());
  for (const bool whole : {false, true}) {
    CHECK(model.recognition().Of(whole).weight.scale == again.recognition().Of(whole).weight.scale);
    CHECK(model.recognition().Of(whole).weight.power == again.recognition().Of(whole).weight.power);
    CHECK(model.recognition().Of(whole).familiarity == again.recognition().Of(whole).familiarity);
  }
}

constexpr double kAroundRateHz = 30;  // alignment sees every frame

// Clips of a label are around the label's own place; subjects move the place a little.
std::vector<core::BuildInput> ClipsAround(const std::vector<int>& labels,
                                          const std::vector<int>& subjects,
                                          const core::MarkerSet& set, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::vector<core::BuildInput> inputs;
  for (const int label : labels) {
    for (const int subject : subjects) {
      for (int take = 0; take < 2; ++take) {
        core::FrameMatrix states = WanderingStates(96, set.dimension_count(), 1000U + label);
        std::mt19937 body(50U + static_cast<unsigned>(subject));
        for (Eigen::Index d = 0; d < states.cols(); ++d) {
          states.col(d).array() += 0.3F * normal(body) + 0.1F * normal(random);
        }
        core::BuildInput input;
        input.clip_id = fmt::format("{}-{}-{}", label, subject, take);
        input.labels = fmt::format("label {}", label);
        input.subject = fmt::format("subject {}", subject);
        input.states = WanderingClips(1, 96, set, 1, kAroundRateHz).front().states;
        input.states.states = states;
        inputs.push_back(std::move(input));
      }
    }
  }
  return inputs;
}

TEST_CASE("Calibrate: new people's clips stay known, a label that is not stored is unknown",
          "[core][calibration]") {
  const core::MarkerSet set = SmallMarkerSet(4);
  core::Model model = ModelOf(ClipsAround({0, 1, 2, 3, 4}, {0, 1, 2, 3, 4}, set, 1), set);
  REQUIRE(core::Calibrate(model, core::RunSerially, {}).ok());
  REQUIRE(model.recognition().unknown == core::UnknownCalibration::kFitted);
  for (const bool whole : {false, true}) {
    core::RecognizeOptions options;
    options.whole = whole;
    const auto unknown_share = [&](const std::vector<core::BuildInput>& inputs) {
      double unknown = 0;
      double count = 0;
      for (const core::BuildInput& input : inputs) {
        const auto windows = core::Recognize(model, input.states, options);
        REQUIRE(windows.ok());
        for (const auto& window : *windows) {
          REQUIRE(window.unknown_probability.has_value());
          unknown += *window.unknown_probability > 0.5 ? 1 : 0;
          ++count;
        }
      }
      return unknown / count;
    };
    INFO("whole: " << whole);
    CHECK(unknown_share(ClipsAround({0, 1, 2, 3, 4}, {7, 8, 9}, set, 2)) < 0.2);
    CHECK(unknown_share(ClipsAround({5, 6, 7}, {7, 8, 9}, set, 2)) > 0.8);
    // Stored motion is always known and familiar.
    const auto stored = ClipsAround({0, 1, 2, 3, 4}, {0, 1, 2, 3, 4}, set, 1);
    CHECK(unknown_share(stored) == 0);
    for (const core::BuildInput& input : stored) {
      const auto windows = core::Recognize(model, input.states, options);
      REQUIRE(windows.ok());
      for (const auto& window : *windows) CHECK(window.familiarity > 0.95);
    }
  }
}

TEST_CASE("Calibrate: states why it has no probability of unknown motion", "[core][calibration]") {
  const core::MarkerSet set = SmallMarkerSet(4);
  const auto calibrated = [&](std::vector<core::BuildInput> inputs) {
    core::Model model = ModelOf(std::move(inputs), set);
    CHECK(model.recognition().unknown == core::UnknownCalibration::kNotFitted);
    REQUIRE(core::Calibrate(model, core::RunSerially, {}).ok());
    CHECK_FALSE(model.recognition().window.unknown.has_value());
    CHECK_FALSE(model.recognition().whole.unknown.has_value());
    return model.recognition().unknown;
  };
  using Reason = core::UnknownCalibration;
  std::vector<core::BuildInput> one = ClipsAround({0}, {0}, set, 1);
  one.resize(1);
  CHECK(calibrated(one) == Reason::kOneClip);
  CHECK(calibrated(ClipsAround({0}, {0, 1, 2}, set, 1)) == Reason::kOneLabel);
  CHECK(calibrated(ClipsAround({0, 1, 2}, {0}, set, 1)) == Reason::kOneSubject);
  std::vector<core::BuildInput> unnamed = ClipsAround({0, 1, 2}, {0, 1, 2}, set, 1);
  for (core::BuildInput& input : unnamed) input.subject.clear();
  CHECK(calibrated(unnamed) == Reason::kOneSubject);
  std::vector<core::BuildInput> few = ClipsAround({0, 1, 2}, {0, 1}, set, 1);
  few.resize(3);
  few[2] = ClipsAround({1}, {1}, set, 1).front();
  CHECK(calibrated(few) == Reason::kTooFewClips);
}

TEST_CASE("Calibrate: a model that is too small keeps the default weights", "[core][calibration]") {
  core::Model single = SmallModel(1, 60, 2, 8, 1);
  REQUIRE(core::Calibrate(single, core::RunSerially, {}).ok());
  CHECK(single.recognition().window.familiarity.empty());
  CHECK(single.recognition().window.weight.scale ==
        core::RecognitionCalibration{}.window.weight.scale);
  core::Model two = SmallModel(2, 60, 2, 8, 1);  // with two labels
  REQUIRE(core::Calibrate(two, core::RunSerially, {}).ok());
  CHECK_FALSE(two.recognition().window.familiarity.empty());
  CHECK(two.recognition().whole.weight.power == core::RecognitionCalibration{}.whole.weight.power);
}

TEST_CASE("ClipsTriedWhole: fewer for very long clips", "[core][calibration]") {
  CHECK(core::ClipsTriedWhole(1, 1, 1200) == 64);
  CHECK(core::ClipsTriedWhole(344, 119'685, 2400) == 64);
  CHECK(core::ClipsTriedWhole(2'000, 1e6, 1200) == 64);
  CHECK(core::ClipsTriedWhole(500, 1e6, 1200) == 39);
  CHECK(core::ClipsTriedWhole(100, 1e6, 1200) == 8);
  CHECK(core::ClipsTriedWhole(1, 1e9, 1200) == 8);
}

TEST_CASE("LeftOutWith: all clips of the subject, if other subjects have the label",
          "[core][calibration]") {
  const core::MarkerSet set = SmallMarkerSet(2);
  std::vector<core::BuildInput> inputs = WanderingClips(5, 30, set, 1);
  const char* const labels[] = {"a", "a", "b", "b", "a"};
  const char* const subjects[] = {"x", "x", "x", "x", "y"};
  for (std::size_t c = 0; c < 5; ++c) {
    inputs[c].labels = labels[c];
    inputs[c].subject = subjects[c];
  }
  const core::Model model = ModelOf(inputs, set);
  const auto left_out_with = [](const core::Model& of, int clip) {
    return core::LeftOutWith(of, of.action_units()->all()[clip]);
  };
  CHECK(left_out_with(model, 0) == std::vector<bool>{true, true, true, true, false});
  CHECK(left_out_with(model, 2) == std::vector<bool>{false, false, true, false, false});
  CHECK(left_out_with(model, 4) == std::vector<bool>{false, false, false, false, true});
  for (core::BuildInput& input : inputs) input.subject.clear();
  CHECK(left_out_with(ModelOf(inputs, set), 0) ==
        std::vector<bool>{true, false, false, false, false});
}

TEST_CASE("SampleUnits: in proportion to labels and subjects, in any order of the clips",
          "[core][calibration]") {
  const core::MarkerSet set = SmallMarkerSet(2);
  std::vector<core::BuildInput> inputs = WanderingClips(40, 30, set, 1);
  for (std::size_t c = 0; c < inputs.size(); ++c) {
    inputs[c].labels = c % 8 == 0 ? "rare" : c % 2 == 0 ? "often" : "most";
    inputs[c].subject = c < 20 ? "x" : "y";
  }
  const core::Model model = ModelOf(inputs, set);
  std::map<std::string, int> counts;
  const std::vector<core::LabelUnit> sample = core::SampleUnits(model, 8);
  REQUIRE(sample.size() == 8);
  for (const core::LabelUnit& unit : sample) {
    ++counts[model.clips()[unit.clip].label()];
    ++counts[model.clips()[unit.clip].subject];
  }
  CHECK(counts ==
        std::map<std::string, int>{{"rare", 1}, {"often", 3}, {"most", 4}, {"x", 5}, {"y", 3}});
  std::vector<int> all;
  for (const core::LabelUnit& unit : core::SampleUnits(model, 100)) all.push_back(unit.clip);
  std::ranges::sort(all);
  CHECK(std::ranges::adjacent_find(all) == all.end());
  CHECK(all.size() == 40);
}

TEST_CASE("StoredMotion: equals the states of the clip", "[core][calibration]") {
  const core::MarkerSet set = SmallMarkerSet(2);
  const auto inputs = WanderingClips(3, 30, set, 1);
  const core::StateSequence motion = core::StoredMotion(ModelOf(inputs, set), 2);
  CHECK(motion.states.isApprox(inputs[2].states.states, 1e-5F));
  CHECK(motion.root_path == inputs[2].states.root_path);
  CHECK(motion.leg_length_m == inputs[2].states.leg_length_m);
}

}  // namespace motiondb::tests::recognition_calibration_test
