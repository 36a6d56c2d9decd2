#include "core/recognition/shortlist.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <set>

#include "core/model/clip_mask.h"
#include "core/model/metric_frames.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::shortlist_test {
namespace {

constexpr int kClips = 90;
constexpr int kFrames = 80;

core::FrameMatrix InMetric(const core::Model& model, int clip, int first, int count) {
  return core::Project(model.metric(),
                       model.states().middleRows(model.clips()[clip].first_frame + first, count));
}

}  // namespace

TEST_CASE("ClipIndex: lists the clips of each node's frames", "[core][recognition]") {
  const core::Model model = SmallModel(12, 90, 3, 6, 5);
  const core::ClipIndex& index = model.clip_index();
  const int layer = model.layer_count();
  REQUIRE(index.node_count() == model.tree().node_count(layer));
  for (int node = 0; node < index.node_count(); ++node) {
    std::set<int> clips;
    core::FrameMatrix mean = core::FrameMatrix::Zero(1, model.states().cols());
    int frames = 0;
    for (int frame = 0; frame < model.frame_count(); ++frame) {
      if (model.tree().node_of_frame(layer, frame) != node) continue;
      clips.insert(model.clip_of_frame(frame));
      mean += model.states().row(frame);
      ++frames;
    }
    const auto listed = index.clips(node);
    CHECK(std::vector<int>(listed.begin(), listed.end()) ==
          std::vector<int>(clips.begin(), clips.end()));
    mean /= static_cast<float>(frames);
    CHECK((core::Project(model.metric(), mean) - index.means().row(node)).norm() <
          1e-3F * (1 + index.means().row(node).norm()));
  }
}

TEST_CASE("ShortlistClips: contains the clip of a window, also with noise", "[core][recognition]") {
  const core::Model model = SmallModel(kClips, kFrames, 3, 4, 3);
  std::mt19937 random(1);
  std::normal_distribution<float> noise;
  int first_of_all = 0;
  for (int clip = 0; clip < kClips; ++clip) {
    core::FrameMatrix part = InMetric(model, clip, 20, 24);
    const auto clean = core::ShortlistClips(model, nullptr, part);
    CHECK(clean.size() == 64);
    CHECK(std::set<int>(clean.begin(), clean.end()).size() == 64);
    CHECK(std::ranges::count(clean, clip) == 1);
    first_of_all += clean.front() == clip;
    for (float& number : part.reshaped()) number += noise(random);
    CHECK(std::ranges::count(core::ShortlistClips(model, nullptr, part), clip) == 1);
  }
  CHECK(first_of_all > kClips / 2);
}

TEST_CASE("ShortlistClips: lists only allowed clips, and all of them if there are few",
          "[core][recognition]") {
  const core::Model many = SmallModel(kClips, kFrames, 3, 4, 3);
  std::vector<bool> allowed(kClips);
  allowed[7] = allowed[50] = true;
  const auto mask = core::ClipMask::Create(many, allowed);
  REQUIRE(mask.ok());
  CHECK(core::ShortlistClips(many, nullptr, InMetric(many, 0, 0, 10), mask->get()) ==
        std::vector<int>{7, 50});

  const core::Model few = SmallModel(9, kFrames, 3, 4, 3);
  CHECK(core::ShortlistClips(few, nullptr, InMetric(few, 4, 0, 1)).size() == 9);
}

}  // namespace motiondb::tests::shortlist_test
