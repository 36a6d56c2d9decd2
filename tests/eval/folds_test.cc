// Tests the folds and temperatures that are used to tune the peers.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/eval/recognizers/cross_validation.h"
#include "tests/eval/recognizers/recognizer.h"
#include "tests/support/threads.h"

namespace motiondb::tests::folds_test {
namespace {

EvalClip Clip(std::string label, std::string source) {
  return {.name = label + source, .label = std::move(label), .source = std::move(source)};
}

}  // namespace

TEST_CASE("Folds: by subject if every label remains, by clips otherwise", "[eval]") {
  const EvalClip a = Clip("walk", "ann"), b = Clip("kick", "ann"), c = Clip("walk", "bob"),
                 d = Clip("kick", "bob"), e = Clip("jump", "ann"), f = Clip("jump", "ann");
  const Folds by_subject = MakeFolds({&a, &b, &c, &d});
  REQUIRE(by_subject.folds.size() == 2);
  CHECK(by_subject.folds[0].test == ClipSet{&a, &b});
  CHECK(by_subject.folds[0].training == ClipSet{&c, &d});

  const ClipSet all{&a, &b, &c, &d, &e, &f};
  const Folds dealt = MakeFolds(all);
  REQUIRE(dealt.folds.size() == 3);
  std::size_t tested = 0;
  for (const Fold& fold : dealt.folds) {
    tested += fold.test.size();
    CHECK(fold.test.size() + fold.training.size() == all.size());
    CHECK(LabelsOf(fold.training) == LabelsOf(all));
    for (const EvalClip* clip : fold.test) {
      CHECK(std::count(fold.training.begin(), fold.training.end(), clip) == 0);
    }
  }
  CHECK(tested == all.size());
}

TEST_CASE("Temperature: calibrates scores", "[eval]") {
  // Two of three are correct by the same margin: the best softmax is 2/3.
  const std::vector<HeldOut> held_out = {{{5, 0}, 0}, {{5, 0}, 0}, {{5, 0}, 1}};
  CHECK(HeldOutAccuracy(held_out) == Approx(2.0 / 3));
  CHECK(Softmax({5, 0}, BestTemperature(held_out))[0] == Approx(2.0 / 3).epsilon(0.05));
  CHECK(Softmax({0, 0, 0}, 1)[1] == Approx(1.0 / 3));
  CHECK(Softmax({-INFINITY, -INFINITY}, 1)[1] == Approx(0.5));
}

TEST_CASE("Threads: each body runs once, with any number of them", "[eval]") {
  for (const int jobs : {1, 3}) {
    std::vector<int> runs(100);
    RunOnThreads(jobs)(100, [&](int i) { ++runs[i]; });
    CHECK(runs == std::vector<int>(100, 1));
  }
}

}  // namespace motiondb::tests::folds_test
