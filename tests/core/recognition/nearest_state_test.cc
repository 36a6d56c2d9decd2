#include <catch2/catch.hpp>

#include "core/model/metric_frames.h"
#include "core/model/model.h"
#include "core/recognition/window_alignment.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::nearest_state_test {

TEST_CASE("NearestState: finds stored motion between the strided frames", "[core][recognition]") {
  const core::Model model = SmallModel(3, 60, 2, 8, 1);
  const int stride = core::FrameStride(model.settings().frame_rate_hz);
  REQUIRE(stride == 2);
  for (const core::ModelClip& clip : model.clips()) {
    for (int f = clip.first_frame; f < clip.first_frame + clip.frame_count; f += stride) {
      CHECK(core::NearestState(model, f, model.states().row(f)) == model.states().row(f));
      if (f + 1 == clip.first_frame + clip.frame_count) continue;
      // A frame that alignment does not see, and a moment between two frames.
      const Eigen::RowVectorXf next = model.states().row(f + 1);
      CHECK(core::NearestState(model, f, next) == next);
      const Eigen::RowVectorXf between = 0.7F * model.states().row(f) + 0.3F * next;
      const Eigen::RowVectorXf found = core::NearestState(model, f, between);
      CHECK((found - between).norm() < 1e-4F * (1 + between.norm()));
    }
  }
}

TEST_CASE("NearestState: stays in the clip, and is never farther than the frame itself",
          "[core][recognition]") {
  const core::Model model = SmallModel(3, 60, 2, 8, 1);
  const core::ModelClip& second = model.clips()[1];
  const int first = second.first_frame;
  // The state is a frame of the clip before.
  const Eigen::RowVectorXf before = model.states().row(first - 1);
  const Eigen::RowVectorXf found = core::NearestState(model, first, before);
  CHECK(found != before);
  CHECK((found - before).norm() <= (model.states().row(first) - before).norm());
}

}  // namespace motiondb::tests::nearest_state_test
