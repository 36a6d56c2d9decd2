// Observers during a change of the model.
#include <catch2/catch.hpp>

#include "core/observe/observer.h"
#include "tests/core/observe/observing.h"

namespace motiondb::tests::observer_model_test {

TEST_CASE("Observer: a new model continues with the window", "[core][observe]") {
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

TEST_CASE("Observer: a model without the requested layer uses its bottom layer",
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

}  // namespace motiondb::tests::observer_model_test
