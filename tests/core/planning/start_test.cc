#include <catch2/catch.hpp>
#include <cmath>

#include "core/planning/synthesis.h"
#include "tests/core/planning/walking_database.h"

namespace motiondb::core::start_test {
namespace {

using tests::WalkingDatabase;

TEST_CASE("Start: a moment of a clip is its own frame", "[planning]") {
  const auto origin = FindOrigins(WalkingDatabase(), {.clip = ClipMoment{"slower", 1.5}}, {});
  REQUIRE(origin.ok());
  CHECK(origin->front().frame == WalkingDatabase().clips()[1].first_frame + 90);
}

TEST_CASE("Start: a moment outside a clip, or in an unknown clip, is an error", "[planning]") {
  const auto outside = FindOrigins(WalkingDatabase(), {.clip = ClipMoment{"slower", 4.5}}, {});
  CHECK(outside.status().code() == absl::StatusCode::kOutOfRange);
  CHECK_THAT(std::string(outside.status().message()), Catch::Contains("slower"));
  CHECK(FindOrigins(WalkingDatabase(), {.clip = ClipMoment{"jump", 0}}, {}).status().code() ==
        absl::StatusCode::kNotFound);
  CHECK(FindOrigins(WalkingDatabase(), {}, {.labels = {"dance"}}).status().code() ==
        absl::StatusCode::kInvalidArgument);
  CHECK_FALSE(
      FindOrigins(WalkingDatabase(), {.clip = ClipMoment{"slower", std::nan("")}}, {}).ok());
}

TEST_CASE("Start: if its clip is not allowed, the most similar allowed frame", "[planning]") {
  const Model& model = WalkingDatabase();
  const auto origin =
      FindOrigins(model, {.clip = ClipMoment{"straight", 1.5}}, {.labels = {"bend"}});
  REQUIRE(origin.ok());
  CHECK(model.clips()[model.clip_of_frame(origin->front().frame)].label() == "bend");
  const int own = model.clips()[0].first_frame + 90;
  for (int f = 0; f < model.frame_count(); ++f) {
    const ModelClip& clip = model.clips()[model.clip_of_frame(f)];
    if (clip.label() != "bend" || f >= clip.first_frame + clip.frame_count - 30) continue;
    CHECK((model.states().row(f) - model.states().row(own)).squaredNorm() >=
          (model.states().row(origin->front().frame) - model.states().row(own)).squaredNorm());
  }
  // It still begins in the state of the clip.
  const Eigen::RowVectorXf state = model.states().row(own).cwiseProduct(model.scale().divisor);
  CHECK((origin->front().state - state).norm() == 0);
}

TEST_CASE(
    "Start: an observation begins at the frame most similar to its last, also with missing markers",
    "[planning]") {
  const Model& model = WalkingDatabase();
  StateSequence seen;
  seen.frame_rate_hz = 60;
  seen.leg_length_m = tests::WalkingFigure::kLeg_m;
  const int frame = model.clips()[3].first_frame + 77;
  seen.states = model.states().middleRows(frame - 10, 11);
  model.scale().Revert(seen.states);
  seen.root_path = model.root_path().middleRows(frame - 10, 11);
  auto origin = FindOrigins(model, {.observation = seen}, {});
  REQUIRE(origin.ok());
  CHECK(origin->front().frame == frame);
  seen.states.row(10).segment(6, 30).setConstant(std::nanf(""));
  origin = FindOrigins(model, {.observation = seen}, {});
  REQUIRE(origin.ok());
  CHECK(origin->front().frame == frame);
  seen.states.row(10).setConstant(std::nanf(""));
  CHECK(FindOrigins(model, {.observation = seen}, {}).status().code() ==
        absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace motiondb::core::start_test
