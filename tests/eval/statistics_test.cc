// Compares the evaluation statistics with values computed by hand and by brute force.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/eval/statistics/accuracy.h"
#include "tests/eval/statistics/auroc.h"
#include "tests/eval/statistics/calibration.h"
#include "tests/eval/table.h"

namespace motiondb::tests::statistics_test {

TEST_CASE("Accuracy: macro accuracy weights labels equally", "[eval]") {
  const std::vector<LabelPair> names = {
      {"walk", "walk"}, {"walk", "walk"}, {"walk", "jog"}, {"walk", "walk"}, {"kick", "walk"}};
  CHECK(Accuracy(names) == Approx(0.6));
  CHECK(AccuracyOf(names, "walk") == Approx(0.75));
  CHECK(MacroAccuracy(names) == Approx(0.375));
  CHECK(std::isnan(Accuracy({})));
}

TEST_CASE("Auroc: by hand, and as the fraction of correctly ordered pairs", "[eval]") {
  CHECK(Auroc({3, 4}, {1, 2}) == 1);
  CHECK(Auroc({1, 2}, {3, 4}) == 0);
  CHECK(Auroc({1, 1}, {1}) == 0.5);
  CHECK(Auroc({2, 3, 5}, {1, 3}) == Approx(4.5 / 6));
  CHECK(std::isnan(Auroc({}, {1})));

  std::mt19937 random(1);
  std::vector<double> known(57);
  std::vector<double> unknown(83);
  for (double& score : known) score = static_cast<double>(random() % 20) + 3;
  for (double& score : unknown) score = static_cast<double>(random() % 20);
  double wins = 0;
  for (const double k : known) {
    for (const double u : unknown) wins += k > u ? 1 : k == u ? 0.5 : 0;
  }
  CHECK(Auroc(known, unknown) == Approx(wins / static_cast<double>(known.size() * unknown.size())));
}

TEST_CASE("Calibration: bins and their error by hand", "[eval]") {
  const std::vector<Claim> claims = {{0.95, true}, {0.95, false}, {0.91, true}, {0.91, true},
                                     {0.55, true}, {1, true},     {0, false},   {0.1, false}};
  const auto bins = Reliability(claims);
  REQUIRE(bins.size() == 10);
  CHECK(bins[9].count == 5);  // 0.95 0.95 0.91 0.91 1
  CHECK(bins[9].confidence == Approx(0.944));
  CHECK(bins[9].accuracy == Approx(0.8));
  CHECK(bins[5].count == 1);
  CHECK(bins[0].count == 2);  // 0 and its upper edge
  CHECK(bins[3].count == 0);
  // (5 |0.8 - 0.944| + 1 |1 - 0.55| + 2 |0 - 0.05|) / 8
  CHECK(CalibrationError(bins) == Approx((0.72 + 0.45 + 0.1) / 8));
  CHECK(std::isnan(CalibrationError(Reliability({}))));
}

TEST_CASE("Calibration: calibrated confidences have no error", "[eval]") {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Claim> honest;
  std::vector<Claim> boasting;
  for (int i = 0; i < 20000; ++i) {
    const double confidence = uniform(random);
    honest.push_back({confidence, uniform(random) < confidence});
    boasting.push_back({confidence, uniform(random) < confidence - 0.3});
  }
  CHECK(CalibrationError(Reliability(honest)) < 0.02);
  CHECK(CalibrationError(Reliability(boasting)) > 0.2);
}

TEST_CASE("Table: the same numbers in Markdown and JSON; NaN is a dash and null", "[eval]") {
  const Table table{.title = "Errors",
                    .columns = {{"80 ms"}, {"ms", 2}},
                    .rows = {{"ours", {1.25, std::nan("")}, "fixed"}},
                    .notes = {"Few."}};
  CHECK(ToMarkdown(table) ==
        "#### Errors\n\n"
        "|      | 80 ms |  ms |\n"
        "|------|------:|----:|\n"
        "| ours |   1.2 |   - |\n"
        "\nFew.\n- ours: fixed\n");
  const auto json = ToJson(table);
  CHECK(json["rows"][0]["figures"]["80 ms"] == 1.25);
  CHECK(json["rows"][0]["figures"]["ms"].is_null());
  CHECK(json["notes"][0] == "Few.");
}

}  // namespace motiondb::tests::statistics_test
