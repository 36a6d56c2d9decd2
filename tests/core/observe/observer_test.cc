#include "core/observe/observer.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/motion/past.h"
#include "core/recognition/metric_observation.h"
#include "core/recognition/shortlist.h"
#include "tests/core/observe/point_motion.h"

namespace motiondb::tests {
namespace {

constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();

std::unique_ptr<core::Observer> Observe(const core::Model& model,
                                        const core::ObserverOptions& options = {},
                                        std::optional<double> leg_length_m = kLegLength_m,
                                        double rate = 60) {
  auto observer = core::Observer::Create(model, PointScheme(), PointScheme().set.markers, rate,
                                         leg_length_m, options);
  INFO(observer.status());
  REQUIRE(observer.ok());
  return *std::move(observer);
}

void Append(core::Observer& observer, std::int64_t first_frame, const core::FrameMatrix& frames) {
  const absl::Status status = observer.Append(first_frame, frames);
  INFO(status);
  REQUIRE(status.ok());
}

core::Observed Answer(core::Observer& observer) {
  auto answer = observer.Answer();
  INFO(answer.status());
  REQUIRE(answer.ok());
  REQUIRE(answer->has_value());
  return **std::move(answer);
}

void CheckLabels(const std::vector<core::LabelScore>& a, const std::vector<core::LabelScore>& b) {
  REQUIRE(a.size() == b.size());
  for (std::size_t l = 0; l < a.size(); ++l) {
    if (std::abs(a[l].probability - b[l].probability) < 1e-9) continue;
    CHECK(a[l].label == b[l].label);
    CHECK(a[l].probability == Approx(b[l].probability).epsilon(1e-3).margin(1e-7));
  }
}

void CheckSame(const core::Observed& a, const core::Observed& b) {
  CHECK(a.state.node == b.state.node);
  CHECK(a.state.probability == Approx(b.state.probability).margin(1e-6));
  CheckLabels(a.labels, b.labels);
  CHECK(a.familiarity == Approx(b.familiarity).margin(0.003));
  REQUIRE(a.horizons.size() == b.horizons.size());
  for (std::size_t h = 0; h < a.horizons.size(); ++h) {
    CHECK(a.horizons[h].seconds == b.horizons[h].seconds);
    CHECK((a.horizons[h].marker_positions_m - b.horizons[h].marker_positions_m).norm() < 1e-4);
    CHECK(a.horizons[h].confidence == Approx(b.horizons[h].confidence).margin(1e-4));
  }
}

// A stream with markers missing here and there; hips are there.
core::MarkerMotion Stream(int frames) {
  core::MarkerMotion motion = PointMotion(frames, 1, 77);
  Hide(motion, 3, 50, 60);
  Hide(motion, 5, 55, 56);
  return motion;
}

// What the questions to the whole say of the window that ends at `frame`.
void CheckAgainstQuestions(const core::Model& model, const core::MarkerMotion& motion, int frame,
                           const core::ObserverOptions& options, const core::Observed& answer) {
  core::MarkerMotion prefix = motion;
  prefix.positions_m.conservativeResize(frame + 1, Eigen::NoChange);
  const core::StateSequence known = PointStates(prefix);
  const int width = static_cast<int>(std::lround(options.window_seconds * 60));
  const auto windows = core::Recognize(model, core::PastAt(known, frame, width),
                                       {.window_seconds = options.window_seconds});
  REQUIRE(windows.ok());
  CAPTURE(frame);
  CheckLabels(answer.labels, windows->back().labels);
  CHECK(answer.familiarity == Approx(windows->back().familiarity).margin(0.003));
  if (options.horizon_seconds.empty()) return;
  core::PredictOptions predict;
  predict.history_seconds = options.history_seconds;
  predict.horizon_seconds = options.horizon_seconds;
  const auto prediction = core::Predict(model, known, predict);
  REQUIRE(prediction.ok());
  REQUIRE(answer.horizons.size() == prediction->horizons.size());
  for (std::size_t h = 0; h < answer.horizons.size(); ++h) {
    CHECK((answer.horizons[h].marker_positions_m - prediction->horizons[h].marker_positions_m)
              .norm() < 1e-3);
    CHECK(answer.horizons[h].expected_error_m ==
          Approx(prediction->horizons[h].expected_error_m).margin(1e-4));
  }
}

}  // namespace

TEST_CASE("Observer: says what Recognize and Predict say of the window at every frame",
          "[core][observe]") {
  const core::MarkerMotion motion = Stream(150);
  for (const bool calibrated : {true, false}) {
    const core::Model model = PointModel(3, 3, calibrated);
    for (const double window_seconds : {0.4, 0.1, 1.2}) {
      core::ObserverOptions options;
      options.window_seconds = window_seconds;
      if (window_seconds == 0.4) options.horizon_seconds = {0.1, 0.5};
      const auto observer = Observe(model, options);
      for (int t = 0; t < 150; ++t) {
        Append(*observer, 1000 + t, motion.positions_m.row(t));
        // Sometimes an answer is asked for at each frame, sometimes at a few.
        if (t % 50 > 20 && t % 4 != 3) continue;
        const core::Observed answer = Answer(*observer);
        CHECK(answer.frame == 1000 + t);
        CHECK(answer.layer == model.layer_count());
        CheckAgainstQuestions(model, motion, t, options, answer);
      }
    }
  }
}

TEST_CASE("Observer: compares the clips that Recognize compares, of many", "[core][observe]") {
  const core::Model model = PointModel(9, 9);
  const core::MarkerMotion motion = Stream(90);
  core::ObservedStates states(PointScheme().set, 60, 30);
  states.set_leg_length_m(kLegLength_m);
  core::WindowRecognizer recognizer(model, 24, 1e-6);
  int shortlists = 0;
  for (int t = 0; t < 90; ++t) {
    REQUIRE(states.Push(motion.positions_m.row(t)));
    const auto answer = recognizer.Recognize(states, {});
    REQUIRE(answer.ok());
    const int width = std::min(t + 1, 24);
    core::FrameMatrix scaled = states.Last(width).states;
    model.scale().Apply(scaled);
    const auto observed = core::MetricObservation::Create(model, scaled);
    REQUIRE(observed.ok());
    const core::FrameMatrix compared =
        observed->projected(core::ComparedFrames(0, width, 2, false), Eigen::all);
    CHECK(recognizer.shortlist().empty() == (observed->own != nullptr));
    if (observed->own == nullptr) {
      CHECK(recognizer.shortlist() == core::ShortlistClips(model, nullptr, compared));
      ++shortlists;
    }
    const auto windows = core::Recognize(model, states.Last(width), {});
    REQUIRE(windows.ok());
    CheckLabels(answer->labels, windows->front().labels);
    CHECK(answer->familiarity == Approx(windows->front().familiarity).margin(0.003));
  }
  CHECK(shortlists > 60);
}

TEST_CASE("Observer: a model without a metric answers by the paper", "[core][observe]") {
  core::ModelParts parts = PointModel(2, 2).parts();
  parts.metric = {};
  const auto model = core::Model::Create(std::move(parts));
  REQUIRE(model.ok());
  const core::MarkerMotion motion = Stream(60);
  const auto observer = Observe(*model);
  Append(*observer, 0, motion.positions_m);
  CheckAgainstQuestions(*model, motion, 59, {}, Answer(*observer));
}

TEST_CASE("Observer: how frames are parted into messages does not matter", "[core][observe]") {
  const core::Model model = PointModel(2, 2);
  const core::MarkerMotion motion = Stream(100);
  const auto at_once = Observe(model);
  Append(*at_once, 7, motion.positions_m);
  const auto one_by_one = Observe(model);
  for (int t = 0; t < 100; ++t) {
    Append(*one_by_one, 7 + t, motion.positions_m.row(t));
    Answer(*one_by_one);
  }
  CheckSame(Answer(*at_once), Answer(*one_by_one));
  CheckSame(Answer(*at_once), Answer(*at_once));  // asking changes nothing
}

TEST_CASE("Observer: late frames are passed over, numbers left out are missing frames",
          "[core][observe]") {
  const core::Model model = PointModel(2, 2);
  const core::MarkerMotion motion = Stream(100);
  const auto observer = Observe(model);
  Append(*observer, 0, motion.positions_m.topRows(40));
  Append(*observer, 30, motion.positions_m.middleRows(30, 15));  // ten of them are late
  CHECK(observer->late_frames() == 10);
  Append(*observer, 3, motion.positions_m.topRows(2));
  CHECK(observer->late_frames() == 12);
  Append(*observer, 50, motion.positions_m.middleRows(50, 50));
  CHECK(observer->missing_frames() == 5);

  core::MarkerMotion with_gap = motion;
  for (int m = 0; m < 6; ++m) Hide(with_gap, m, 45, 50);
  const auto told = Observe(model);
  Append(*told, 0, with_gap.positions_m);
  CHECK(told->missing_frames() == 0);
  CheckSame(Answer(*observer), Answer(*told));
}

TEST_CASE("Observer: a gap longer than the window starts anew", "[core][observe]") {
  const core::Model model = PointModel(2, 2);
  const core::MarkerMotion motion = Stream(100);
  const auto fresh = Observe(model);
  Append(*fresh, 0, motion.positions_m.bottomRows(30));
  for (const std::int64_t gap : {std::int64_t{25}, std::int64_t{1} << 62, kMost - 200}) {
    const auto observer = Observe(model);
    Append(*observer, 0, motion.positions_m.topRows(70));
    Append(*observer, 70 + gap, motion.positions_m.bottomRows(30));
    CHECK(observer->missing_frames() == gap);
    CHECK(observer->kept_frames() == 30);
    CheckSame(Answer(*observer), Answer(*fresh));
  }
  const auto observer = Observe(model);
  Append(*observer, kLeast, motion.positions_m.topRows(70));
  Append(*observer, kMost - 29, motion.positions_m.bottomRows(30));
  CHECK(observer->missing_frames() == kMost);
  CheckSame(Answer(*observer), Answer(*fresh));
  Append(*observer, kMost, motion.positions_m.row(0));
  CHECK(observer->late_frames() == 1);
}

TEST_CASE("Observer: has nothing to say before it has seen both hips", "[core][observe]") {
  const core::Model model = PointModel(2, 2);
  core::MarkerMotion motion = Stream(100);
  Hide(motion, 0, 0, 10);
  for (const bool is_told : {true, false}) {
    const auto observer = Observe(model, {}, is_told ? std::optional(kLegLength_m) : std::nullopt);
    CHECK_FALSE(observer->Answer()->has_value());
    for (int t = 0; t < 100; ++t) {
      Append(*observer, t, motion.positions_m.row(t));
      CHECK(observer->Answer()->has_value() == (t >= 10));
      CHECK(observer->leg_length_m().has_value() == (is_told || t >= 10));
    }
  }
}

TEST_CASE("Observer: measures the leg over a second, and answers as if it had been told",
          "[core][observe]") {
  const core::Model model = PointModel(2, 2);
  const core::MarkerMotion motion = Stream(150);
  const auto measured = Observe(model, {}, std::nullopt);
  std::optional<double> settled;
  for (int t = 0; t < 150; ++t) {
    Append(*measured, t, motion.positions_m.row(t));
    const core::Observed answer = Answer(*measured);
    if (t == 59) {
      settled = measured->leg_length_m();
      core::MarkerMotion second = motion;
      second.positions_m.conservativeResize(60, Eigen::NoChange);
      CHECK(*settled == *core::EstimateLegLength(PointScheme().set, second));
    }
    if (t >= 59) CHECK(measured->leg_length_m() == settled);
    if (t % 10 != 9) continue;
    const auto told = Observe(model, {}, measured->leg_length_m());
    Append(*told, 0, motion.positions_m.topRows(t + 1));
    CheckSame(answer, Answer(*told));
  }
}

TEST_CASE("Observer: frames at another rate are resampled", "[core][observe]") {
  const core::Model model = PointModel(2, 2);
  const core::MarkerMotion motion = PointMotion(200, 1, 77, 120);
  const auto observer = Observe(model, {}, kLegLength_m, 120);
  Append(*observer, 0, motion.positions_m);
  auto halved = core::Resample(motion, 60);
  REQUIRE(halved.ok());
  const auto expected = Observe(model);
  Append(*expected, 0, halved->positions_m);
  CheckSame(Answer(*observer), Answer(*expected));
  CHECK(Answer(*observer).frame == 198);  // 199 is between two frames of the model
  const auto slow = Observe(model, {}, kLegLength_m, 25);
  Append(*slow, 0, motion.positions_m.topRows(40));
  CHECK(Answer(*slow).frame == 39);
}

TEST_CASE("Observer: another model takes over the window", "[core][observe]") {
  const core::Model model = PointModel(2, 2);
  const core::Model other = PointModel(3, 2);
  const core::MarkerMotion motion = Stream(140);
  core::ObserverOptions options;
  options.horizon_seconds = {0.2};
  const auto observer = Observe(model, options);
  Append(*observer, 0, motion.positions_m.topRows(100));
  Answer(*observer);
  REQUIRE(observer->Replace(other).ok());
  const int kept = observer->kept_frames();
  CHECK(kept == 60);
  const auto fresh = Observe(other, options);
  Append(*fresh, 100 - kept, motion.positions_m.middleRows(100 - kept, kept));
  CheckSame(Answer(*observer), Answer(*fresh));
  CHECK(Answer(*observer).labels.size() == 3);
  Append(*observer, 100, motion.positions_m.bottomRows(40));
  Append(*fresh, 100, motion.positions_m.bottomRows(40));
  CheckSame(Answer(*observer), Answer(*fresh));

  core::ModelParts parts = other.parts();
  parts.settings.frame_rate_hz = 30;
  const auto slow = core::Model::Create(std::move(parts));
  REQUIRE(slow.ok());
  CHECK(observer->Replace(*slow).code() == absl::StatusCode::kInvalidArgument);
  CheckSame(Answer(*observer), Answer(*fresh));
}

TEST_CASE("Observer: a model without the layer asked for answers by its bottom layer",
          "[core][observe]") {
  const core::Model deep = PointModel(4, 3);
  const core::Model shallow = PointModel(1, 1);
  REQUIRE(shallow.layer_count() < deep.layer_count());
  core::MarkerMotion motion = Stream(90);
  Hide(motion, 4, 50, 90);
  core::ObserverOptions options;
  options.horizon_seconds = {0.2};
  options.layer = deep.layer_count();
  const auto observer = Observe(deep, options);
  Append(*observer, 0, motion.positions_m.topRows(60));
  CHECK(Answer(*observer).layer == deep.layer_count());
  REQUIRE(observer->Replace(shallow).ok());
  CHECK(Answer(*observer).layer == shallow.layer_count());

  options.layer = 0;
  const auto fresh = Observe(shallow, options);
  Append(*fresh, 0, motion.positions_m.topRows(60));
  CheckSame(Answer(*observer), Answer(*fresh));
  Append(*observer, 60, motion.positions_m.bottomRows(30));
  Append(*fresh, 60, motion.positions_m.bottomRows(30));
  CheckSame(Answer(*observer), Answer(*fresh));
  REQUIRE(observer->Replace(deep).ok());
  CHECK(Answer(*observer).layer == deep.layer_count());
}

TEST_CASE("Observer: what does not fit is refused by name, and nothing is taken",
          "[core][observe]") {
  const core::Model model = PointModel(2, 1);
  const core::MarkerMotion motion = Stream(60);
  const auto observer = Observe(model);
  Append(*observer, 0, motion.positions_m);
  const core::Observed before = Answer(*observer);
  core::FrameMatrix bad = motion.positions_m.topRows(5);
  bad(4, 2) = std::numeric_limits<float>::infinity();
  CHECK(observer->Append(60, bad).code() == absl::StatusCode::kInvalidArgument);
  bad(4, 2) = -1e30F;
  CHECK(observer->Append(60, bad).code() == absl::StatusCode::kInvalidArgument);
  CHECK(observer->Append(60, bad.leftCols(15)).code() == absl::StatusCode::kInvalidArgument);
  CHECK(observer->Append(kMost - 3, motion.positions_m.topRows(5)).code() ==
        absl::StatusCode::kInvalidArgument);
  CHECK(observer->Append(60, core::FrameMatrix(0, 18)).ok());
  CHECK(observer->Append(60, core::FrameMatrix()).ok());
  CheckSame(Answer(*observer), before);
  CHECK(observer->Answer([] { return true; }).status().code() == absl::StatusCode::kCancelled);
  CheckSame(Answer(*observer), before);

  using Catch::Matchers::Contains;
  const auto message = [&](const std::function<void(core::ObserverOptions&)>& change,
                           std::optional<double> leg_length_m = 1.0) {
    core::ObserverOptions options;
    change(options);
    const auto made = core::Observer::Create(model, PointScheme(), PointScheme().set.markers, 60,
                                             leg_length_m, options);
    CHECK_FALSE(made.ok());
    return std::string(made.status().message());
  };
  for (const double seconds : {0.0, -1.0, 1e9, std::nan(""), HUGE_VAL}) {
    CHECK_THAT(message([&](auto& o) { o.window_seconds = seconds; }), Contains("window_seconds"));
    CHECK_THAT(message([&](auto& o) { o.history_seconds = seconds; }), Contains("history_seconds"));
    CHECK_THAT(message([](auto&) {}, seconds), Contains("leg_length_m"));
  }
  CHECK_THAT(message([](auto& o) {
               o.horizon_seconds = {0.1, -1};
             }),
             Contains("horizon_seconds[1]"));
  CHECK_THAT(message([](auto& o) { o.transition_floor = 2; }), Contains("transition_floor"));
  CHECK_THAT(message([](auto& o) { o.layer = 99; }), Contains("layer"));
}

TEST_CASE("Observer: odd streams do no harm", "[core][observe]") {
  const core::Model model = PointModel(2, 2);
  core::ObserverOptions options;
  options.horizon_seconds = {0.2};
  const auto observer = Observe(model, options, std::nullopt);
  core::MarkerMotion motion = Stream(200);
  Hide(motion, 0, 80, 150);                               // one hip for long
  for (int m = 0; m < 6; ++m) Hide(motion, m, 100, 140);  // and then nothing at all
  motion.positions_m.row(160).setConstant(5);             // all in one point
  motion.positions_m.row(161).setConstant(-1e5F);         // far off
  motion.positions_m.row(162) *= 1000;
  for (int t = 0; t < 200; ++t) {
    Append(*observer, t, motion.positions_m.row(t));
    const core::Observed answer = Answer(*observer);
    CHECK(std::isfinite(answer.state.probability));
    double sum = 0;
    for (const core::LabelScore& label : answer.labels) sum += label.probability;
    CHECK(sum == Approx(1));
    CHECK(answer.familiarity >= 0);
    CHECK(answer.familiarity <= 1);
  }
}

}  // namespace motiondb::tests
