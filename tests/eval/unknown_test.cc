// Tests the decision between known and unknown motion, and the peers' probability of unknown
// motion.
#include "tests/eval/statistics/unknown.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "core/recognition/unknown.h"
#include "tests/eval/recognizers/recognizer.h"
#include "tests/eval/recognizers/unknown_regression.h"

namespace motiondb::tests::unknown_test {
namespace {

constexpr double kMissing = -std::numeric_limits<double>::infinity();

// Scores with many ties, of two labels and three subjects.
std::vector<UnknownAnswer> RandomAnswers(unsigned seed) {
  std::mt19937 random(seed);
  std::vector<UnknownAnswer> answers;
  for (int i = 0; i < 200; ++i) {
    const bool is_unknown = random() % 4 == 0;
    answers.push_back({static_cast<double>(random() % 15) + (is_unknown ? 5 : 0), is_unknown,
                       random() % 2 == 0 ? "walk" : "kick", std::string(1, "abc"[random() % 3])});
  }
  return answers;
}

// Returns the lowest threshold of all the scores that satisfies the definition.
double CountedThreshold(const std::vector<double>& scores, double kept) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const double threshold : scores) {
    const auto below = std::ranges::count_if(scores, [&](double s) { return s <= threshold; });
    if (static_cast<double>(below) >= kept * static_cast<double>(scores.size()) - 1e-6) {
      lowest = std::min(lowest, threshold);
    }
  }
  return lowest;
}

constexpr int kLabels = 8;

// Motions of `clips` clips of each label. The own label scores `margin` more than the others; each
// score has noise, and each motion has noise that all its scores share.
std::vector<HeldOut> RandomMotions(int clips, double margin, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<HeldOut> held_out;
  for (int c = 0; c < kLabels * clips; ++c) {
    HeldOut motion{{}, c % kLabels, c};
    const double shared = normal(random);
    for (int l = 0; l < kLabels; ++l) motion.scores.push_back(shared + normal(random));
    motion.scores[static_cast<std::size_t>(motion.truth)] += margin;
    held_out.push_back(motion);
  }
  return held_out;
}

HeldOut WithoutOwnLabel(HeldOut motion) {
  motion.scores[static_cast<std::size_t>(motion.truth)] = kMissing;
  return motion;
}

}  // namespace

TEST_CASE("Threshold: the lowest that keeps the share, by counting", "[eval]") {
  CHECK(KeepingThreshold({4, 1, 3, 2, 5}, 0.8) == 4);
  CHECK(KeepingThreshold({4, 1, 3, 2, 5}, 0.81) == 5);
  CHECK(KeepingThreshold({7}, 0.5) == 7);
  std::vector<double> twenty;
  for (int i = 1; i <= 20; ++i) twenty.push_back(i);
  CHECK(KeepingThreshold(twenty, 0.95) == 19);
  for (unsigned seed = 0; seed < 30; ++seed) {
    std::mt19937 random(seed);
    std::vector<double> scores(1 + random() % 40);
    for (double& score : scores) score = static_cast<double>(random() % 12);
    for (const double kept : {0.0, 0.3, 0.8, 0.95, 1.0}) {
      CHECK(KeepingThreshold(scores, kept) == CountedThreshold(scores, kept));
    }
  }
}

TEST_CASE("Decision: the threshold comes from the known answers of the other subjects", "[eval]") {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const std::vector<UnknownAnswer> answers = RandomAnswers(seed);
    for (const double kept : {0.8, 0.9, 0.95}) {
      const std::vector<bool> decided = DecideUnknown(answers, kept);
      double found = 0, unknown = 0, lost_walks = 0, walks = 0;
      for (std::size_t i = 0; i < answers.size(); ++i) {
        std::vector<double> others;
        for (const UnknownAnswer& other : answers) {
          if (!other.is_unknown && other.subject != answers[i].subject) {
            others.push_back(other.score);
          }
        }
        const bool is_above = answers[i].score > CountedThreshold(others, kept);
        CHECK(decided[i] == is_above);
        unknown += answers[i].is_unknown ? 1 : 0;
        found += answers[i].is_unknown && is_above ? 1 : 0;
        if (answers[i].is_unknown || answers[i].label != "walk") continue;
        ++walks;
        lost_walks += is_above ? 1 : 0;
      }
      CHECK(DecidedUnknown(answers, decided, true) == Approx(found / unknown));
      CHECK(DecidedUnknown(answers, decided, false, "walk") == Approx(lost_walks / walks));
      CHECK(std::isnan(DecidedUnknown(answers, decided, true, "jump")));
    }
  }
}

TEST_CASE("Answer: unknown above one half, and then no label is correct", "[eval]") {
  Recognition recognition{"walk", {0.1, 0.35}, 0, 0.55};
  CHECK(recognition.answer() == kUnknown);
  CHECK(recognition.answer_probability() == 0.55);
  recognition = {"walk", {0.1, 0.4}, 0, 0.5};
  CHECK(recognition.answer() == "walk");
  CHECK(recognition.answer_probability() == 0.4);
  recognition = {"walk", {0.2, 0.8}};
  CHECK(recognition.answer() == "walk");
  CHECK_FALSE(IsUnknown(std::nullopt));
}

TEST_CASE("Unknown regression: scores that say nothing leave the prior", "[eval]") {
  std::vector<HeldOut> held_out;
  for (int c = 0; c < 300; ++c) held_out.push_back({{0, 0, 0}, c % 3, c});
  const auto fitted = FitUnknownRegression(held_out, 1);
  REQUIRE(fitted);
  // Without the own label the odds are 1 : 1 instead of 1 : 2, which tells the two kinds apart, but
  // in the wrong direction.
  CHECK(fitted->odds_weight == 0);
  CHECK(fitted->Probability({0, 0, 0}) == Approx(core::kUnknownShare));
  CHECK(fitted->Probability({3, 0, 0}) == Approx(core::kUnknownShare).margin(0.01));
}

TEST_CASE("Unknown regression: calibrated on other motions of the same kind", "[eval]") {
  const auto fitted = FitUnknownRegression(RandomMotions(1000, 3, 1), 1);
  REQUIRE(fitted);
  CHECK(fitted->score_weight < 0);
  CHECK(fitted->odds_weight < 0);
  double known_sum = 0;
  double unknown_sum = 0;
  const std::vector<HeldOut> others = RandomMotions(1000, 3, 2);
  for (const HeldOut& motion : others) {
    known_sum += fitted->Probability(motion.scores);
    unknown_sum += fitted->Probability(WithoutOwnLabel(motion).scores);
  }
  const auto count = static_cast<double>(others.size());
  constexpr double kShare = core::kUnknownShare;
  CHECK(((1 - kShare) * known_sum + kShare * unknown_sum) / count == Approx(kShare).margin(0.01));
  CHECK(unknown_sum > 2 * known_sum);
}

TEST_CASE("Unknown regression: no other weights have less loss", "[eval]") {
  const std::vector<HeldOut> held_out = RandomMotions(100, 3, 3);
  const auto fitted = FitUnknownRegression(held_out, 0.7);
  REQUIRE(fitted);
  const auto loss = [&](const UnknownRegression& regression) {
    double sum = 0;
    for (const HeldOut& motion : held_out) {
      sum -= (1 - core::kUnknownShare) * std::log(1 - regression.Probability(motion.scores));
      sum -= core::kUnknownShare * std::log(regression.Probability(WithoutOwnLabel(motion).scores));
    }
    return sum / static_cast<double>(held_out.size());
  };
  for (double UnknownRegression::*weight :
       {&UnknownRegression::intercept, &UnknownRegression::score_weight,
        &UnknownRegression::odds_weight}) {
    for (const double step : {-0.05, 0.05}) {
      UnknownRegression other = *fitted;
      other.*weight += step;
      CHECK(loss(other) > loss(*fitted));
    }
  }
}

TEST_CASE("Unknown regression: needs clips of both kinds; a label that no fold learns is unknown",
          "[eval]") {
  CHECK_FALSE(FitUnknownRegression({}, 1));
  CHECK_FALSE(FitUnknownRegression({RandomMotions(1, 3, 4).front()}, 1));
  std::vector<HeldOut> held_out = RandomMotions(3, 3, 5);
  CHECK(FitUnknownRegression(held_out, 1));
  for (HeldOut& motion : held_out) motion = WithoutOwnLabel(motion);
  CHECK_FALSE(FitUnknownRegression(held_out, 1));  // none is known
  for (HeldOut& motion : held_out) motion.scores.assign(kLabels, kMissing);
  CHECK_FALSE(FitUnknownRegression(held_out, 1));
}

}  // namespace motiondb::tests::unknown_test
