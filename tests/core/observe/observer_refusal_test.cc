// Invalid input of an observer.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>

#include "core/observe/observer.h"
#include "tests/core/observe/observing.h"

namespace motiondb::tests::observer_refusal_test {
namespace {

constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();

}  // namespace

TEST_CASE("Observer: invalid input is refused by name, and no frame is added", "[core][observe]") {
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

}  // namespace motiondb::tests::observer_refusal_test
