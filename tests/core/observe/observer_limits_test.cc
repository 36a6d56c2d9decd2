// Streams with excessive options.
#include <catch2/catch.hpp>

#include "core/observe/observer.h"
#include "tests/core/observe/point_motion.h"

namespace motiondb::tests::observer_limits_test {
namespace {

using Catch::Contains;

TEST_CASE("Observer: a window of too many frames is refused with its field",
          "[core][observe][hostile]") {
  core::ModelParts parts = PointModel(3, 1).parts();
  parts.settings.frame_rate_hz = 10'000;
  const auto model = core::Model::Create(std::move(parts));
  REQUIRE(model.ok());
  const auto create = [&](const core::ObserverOptions& options) {
    return core::Observer::Create(*model, PointScheme(), PointScheme().set.markers, 10'000,
                                  std::nullopt, options)
        .status();
  };
  CHECK(create({}).ok());
  const absl::Status window = create({.window_seconds = 60});
  REQUIRE(window.code() == absl::StatusCode::kInvalidArgument);
  CHECK_THAT(std::string(window.message()), Contains("window_seconds: expected at most 16384"));
  const absl::Status history = create({.history_seconds = 2});
  REQUIRE(history.code() == absl::StatusCode::kInvalidArgument);
  CHECK_THAT(std::string(history.message()), Contains("history_seconds: expected at most 16384"));
}

TEST_CASE("Observer: adding many frames can be cancelled", "[core][observe][hostile]") {
  const core::Model model = PointModel(3, 1);
  auto observer =
      core::Observer::Create(model, PointScheme(), PointScheme().set.markers, 60, kLegLength_m, {});
  REQUIRE(observer.ok());
  const core::MarkerMotion motion = PointMotion(1000, 1, 5);
  int checks = 0;
  const absl::Status status =
      (*observer)->Append(0, motion.positions_m, [&] { return ++checks == 3; });
  CHECK(status.code() == absl::StatusCode::kCancelled);
  CHECK(checks == 3);
}

}  // namespace
}  // namespace motiondb::tests::observer_limits_test
