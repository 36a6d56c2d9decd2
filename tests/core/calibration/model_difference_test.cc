#include "core/calibration/model_difference.h"

#include <catch2/catch.hpp>

#include "core/model/model_builder.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::model_difference_test {
namespace {

core::Model Built(std::vector<core::BuildInput> clips) {
  auto model = core::BuildModel({.min_frames = 8}, SmallMarkerSet(5), std::move(clips),
                                core::RunSerially, nullptr);
  REQUIRE(model.ok());
  return *std::move(model);
}

}  // namespace

TEST_CASE("CompareModels: measures the difference between an extended and a built model",
          "[core][calibration]") {
  const auto clips = WanderingClips(14, 150, SmallMarkerSet(5), 4);
  const core::Model base = Built({clips.begin(), clips.begin() + 12});
  const auto extended =
      core::ExtendModel(base, {clips.begin() + 12, clips.end()}, core::RunSerially);
  REQUIRE(extended.ok());
  const core::Model built = Built(clips);
  const auto difference = core::CompareModels(*extended, built, core::RunSerially);
  CHECK(difference.bottom_nodes_before == base.tree().node_count(base.layer_count()));
  CHECK(difference.bottom_nodes_after == built.tree().node_count(built.layer_count()));
  CHECK(difference.spread_after > 0);
  // A build splits nodes with added frames at least as finely.
  CHECK(difference.spread_after < 1.1 * difference.spread_before);
  CHECK(difference.windows == 2);
  CHECK(difference.same_label == 2);  // two labels with different poses

  // Both are the same model without added clips.
  const auto none = core::CompareModels(built, built, core::RunSerially);
  CHECK(none.spread_before == none.spread_after);
  CHECK(none.windows == 0);
}

}  // namespace motiondb::tests::model_difference_test
