#include "core/calibration/evidence_weight.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace motiondb::tests::evidence_weight_test {
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

}  // namespace motiondb::tests::evidence_weight_test
