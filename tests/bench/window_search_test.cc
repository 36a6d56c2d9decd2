#include "tests/bench/window_search.h"

#include <catch2/catch.hpp>
#include <random>

#include "tests/support/threads.h"

namespace motiondb::tests::window_search_test {
namespace {

core::FrameMatrix RandomFrames(int frames, int dimensions, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  return core::FrameMatrix::NullaryExpr(frames, dimensions, [&] { return normal(random); });
}

NearestWindow ByHand(const core::FrameMatrix& frames, const std::vector<core::ModelClip>& clips,
                     const core::FrameMatrix& window) {
  NearestWindow nearest{.distance = INFINITY};
  for (std::size_t c = 0; c < clips.size(); ++c) {
    for (int s = 0; s + window.rows() <= clips[c].frame_count; ++s) {
      const int at = clips[c].first_frame + s;
      const float distance = (frames.middleRows(at, window.rows()) - window).squaredNorm();
      if (distance < nearest.distance) nearest = {static_cast<int>(c), at, distance};
    }
  }
  return nearest;
}

}  // namespace

TEST_CASE("Window search: agrees with brute force, for clips of any length", "[bench]") {
  // Clips that end within, at and across blocks and parts, some shorter than a window.
  std::vector<core::ModelClip> clips;
  int total = 0;
  for (const int count : {3, 4084, 9, 30, 65536, 5, 100, 2}) {
    clips.push_back({"", "", total, count, 1, ""});
    total += count;
  }
  const core::FrameMatrix frames = RandomFrames(total, 6, 1);
  for (unsigned seed = 2; seed < 12; ++seed) {
    const core::FrameMatrix window = RandomFrames(5, 6, seed);
    const NearestWindow found = FindNearestWindow(frames, clips, window, RunOnThreads(2));
    const NearestWindow expected = ByHand(frames, clips, window);
    CHECK(found.clip == expected.clip);
    CHECK(found.first_frame == expected.first_frame);
    CHECK(found.distance == Approx(expected.distance).epsilon(1e-3));
  }
  for (const int at : {4070, 4096, 4110, 4126, 32768, 69600}) {  // a stored window
    const core::FrameMatrix window = frames.middleRows(at, 5);
    CHECK(FindNearestWindow(frames, clips, window, RunOnThreads(2)).first_frame ==
          ByHand(frames, clips, window).first_frame);
  }
}

TEST_CASE("Window search: finds nothing if all clips are shorter than the window", "[bench]") {
  const core::FrameMatrix frames = RandomFrames(8, 6, 1);
  const std::vector<core::ModelClip> clips{{"", "", 0, 4, 1, ""}, {"", "", 4, 4, 1, ""}};
  CHECK(FindNearestWindow(frames, clips, RandomFrames(5, 6, 2), core::RunSerially).clip == -1);
}

}  // namespace motiondb::tests::window_search_test
