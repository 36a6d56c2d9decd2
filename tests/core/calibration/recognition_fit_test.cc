#include "core/calibration/recognition_fit.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace motiondb::tests::recognition_fit_test {
namespace {

// Evidence that is `too_strong` times what it should be, of observations of 1 to `frames` frames,
// each frame adding to it.
std::vector<core::JudgedSample> Samples(int count, double too_strong, int frames, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  std::vector<core::JudgedSample> samples;
  for (int i = 0; i < count; ++i) {
    core::JudgedSample sample;
    sample.frames = 1 + static_cast<int>(random() % static_cast<unsigned>(frames));
    std::vector<double> logs(4);
    double all = 0;
    for (double& log : logs) {
      log = 2 * normal(random);
      all += std::exp(log);
    }
    double place = uniform(random) * all;
    while (sample.label < 3 && place > std::exp(logs[sample.label])) {
      place -= std::exp(logs[sample.label++]);
    }
    for (const double log : logs) sample.evidence.push_back(too_strong * sample.frames * log);
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace

TEST_CASE("FitEvidenceWeight: finds the scale of overconfident evidence", "[core][calibration]") {
  const auto weight = core::FitEvidenceWeight(Samples(2000, 8, 1, 1), {1});
  CHECK(weight.scale == Approx(1 / 8.0).epsilon(0.2));
  CHECK(weight.power == 1);
}

TEST_CASE("FitEvidenceWeight: finds power 0 for dependent frames", "[core][calibration]") {
  const auto samples = Samples(2000, 3, 100, 2);
  const auto weight = core::FitEvidenceWeight(samples, {0, 0.25, 0.5, 0.75, 1});
  CHECK(weight.power == 0);
  CHECK(weight.scale == Approx(1 / 3.0).epsilon(0.2));
  CHECK(core::NegativeLogLikelihood(Samples(500, 3, 100, 3), weight) <
        core::NegativeLogLikelihood(Samples(500, 3, 100, 3), {1, 1}));
}

TEST_CASE("NegativeLogLikelihood: equals that of the softmax", "[core][calibration]") {
  const core::JudgedSample sample{{-3000, -3002}, 1, 4};
  const double at = 0.5 * std::pow(4, -0.5);
  CHECK(core::NegativeLogLikelihood({sample}, {0.5, 0.5}) ==
        Approx(std::log(1 + std::exp(2 * at))));
}

namespace {

const std::vector<std::string> kLabels = {"hop", "jog", "sit", "walk"};

// Log distance of the known clips of a label.
double OfLabel(std::size_t label) { return 1 + 2 * static_cast<double>(label); }

// Clips of labels with different distances: hop clips are more alike than walk clips. Unknown
// motion differs by `gap` more from the label that it resembles.
std::vector<core::UnknownSample> Samples(int clips, double gap, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<core::UnknownSample> samples;
  for (int clip = 0; clip < clips; ++clip) {
    const auto label = static_cast<std::size_t>(clip) % kLabels.size();
    for (const bool is_unknown : {false, true}) {
      core::UnknownSample sample{is_unknown, clip, label, {}, 0};
      sample.best.label = is_unknown ? (label + 1) % kLabels.size() : label;
      sample.best.log_distance =
          OfLabel(sample.best.label) + normal(random) + (is_unknown ? gap : 0);
      sample.own_log_distance = is_unknown ? 0 : sample.best.log_distance;
      sample.best.lead = std::abs(0.3 * normal(random)) + (is_unknown ? 0 : 1);
      samples.push_back(sample);
    }
  }
  return samples;
}

double Probability(const core::UnknownModel& model, const core::BestLabel& best) {
  double log_odds = model.intercept;
  const auto features = core::UnknownFeatures(best, model.labels[best.label].log_distance);
  for (std::size_t i = 0; i < features.size(); ++i) log_odds += model.weights[i] * features[i];
  return 1 / (1 + std::exp(-log_odds));
}

}  // namespace

TEST_CASE("FitUnknownModel: probabilities equal frequencies at the assumed share of unknown motion",
          "[core][calibration]") {
  const auto model = core::FitUnknownModel(kLabels, Samples(400, 2, 1));
  REQUIRE(model.has_value());
  // Of new samples, with the assumed share.
  double surplus[10] = {};
  double total = 0;
  double errors[2] = {};
  double count[2] = {};
  for (const core::UnknownSample& sample : Samples(4000, 2, 2)) {
    const double weight = sample.is_unknown ? core::kUnknownShare : 1 - core::kUnknownShare;
    const double p = Probability(*model, sample.best);
    surplus[std::min(9, static_cast<int>(10 * p))] += weight * (p - (sample.is_unknown ? 1 : 0));
    total += weight;
    errors[sample.is_unknown] += (p > 0.5) != sample.is_unknown ? 1 : 0;
    ++count[sample.is_unknown];
  }
  double error = 0;
  for (const double bin : surplus) error += std::abs(bin) / total;
  CHECK(error < 0.02);
  CHECK(errors[0] / count[0] < 0.05);
  CHECK(errors[1] / count[1] < 0.35);
}

TEST_CASE("FitUnknownModel: each label has its own distance, shrunk towards that of all",
          "[core][calibration]") {
  const auto model = core::FitUnknownModel(kLabels, Samples(400, 2, 1));
  REQUIRE(model.has_value());
  REQUIRE(model->labels.size() == kLabels.size());
  CHECK(model->typical_log_distance == Approx(4).margin(0.3));
  for (std::size_t l = 0; l < kLabels.size(); ++l) {
    CHECK(model->labels[l].label == kLabels[l]);
    CHECK(model->labels[l].log_distance == Approx((100 * OfLabel(l) + 4 * 4) / 104).margin(0.4));
  }
}

TEST_CASE("FitUnknownModel: a weight never contradicts the meaning of its feature",
          "[core][calibration]") {
  // Unknown motion that differs less than known motion: only the lead is of use.
  std::vector<core::UnknownSample> samples = Samples(60, -3, 3);
  const auto by_lead = core::FitUnknownModel(kLabels, samples);
  REQUIRE(by_lead.has_value());
  CHECK(by_lead->weights[0] == 0);
  CHECK(by_lead->weights[1] < 0);
  // Its lead is larger, too: nothing to learn.
  for (core::UnknownSample& sample : samples) {
    if (sample.is_unknown) sample.best.lead += 4;
  }
  const auto constant = core::FitUnknownModel(kLabels, samples);
  REQUIRE(constant.has_value());
  CHECK(constant->weights[0] == 0);
  CHECK(constant->weights[1] == 0);
}

TEST_CASE("FitUnknownModel: with two labels the lead is not used", "[core][calibration]") {
  std::vector<core::UnknownSample> samples;
  for (core::UnknownSample sample : Samples(80, 2, 4)) {
    sample.label %= 2;
    sample.best.label %= 2;
    if (sample.is_unknown) sample.best.lead = 0;  // one label is left
    samples.push_back(sample);
  }
  const auto model = core::FitUnknownModel({"hop", "jog"}, samples);
  REQUIRE(model.has_value());
  CHECK(model->weights[0] > 0);
  CHECK(model->weights[1] == 0);
}

TEST_CASE("FitUnknownModel: needs four clips of two labels of each kind", "[core][calibration]") {
  CHECK(core::FitUnknownModel(kLabels, Samples(4, 2, 5)).has_value());
  CHECK_FALSE(core::FitUnknownModel(kLabels, Samples(3, 2, 5)).has_value());
  CHECK_FALSE(core::FitUnknownModel(kLabels, {}).has_value());
  std::vector<core::UnknownSample> samples = Samples(40, 2, 5);
  std::erase_if(samples, [](const core::UnknownSample& sample) { return sample.is_unknown; });
  CHECK_FALSE(core::FitUnknownModel(kLabels, samples).has_value());
  samples = Samples(40, 2, 5);
  std::erase_if(samples, [](const core::UnknownSample& sample) { return sample.label != 2; });
  CHECK_FALSE(core::FitUnknownModel(kLabels, samples).has_value());
}

}  // namespace motiondb::tests::recognition_fit_test
