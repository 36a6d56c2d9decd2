#include "core/model/clip_mask.h"

#include <set>

#include "core/model/clip_graphs.h"
#include "core/motion/error.h"
#include "tests/support/some_clips.h"
#include "tests/support/synthetic_states.h"
#include "tests/support/threads.h"

namespace motiondb::tests::clip_mask_test {
namespace {

std::vector<core::ModelClip> ClipsOf(const core::Model& model, const core::ClipMask& mask) {
  std::vector<core::ModelClip> clips;
  for (const int clip : mask.clips()) clips.push_back(model.clips()[clip]);
  return clips;
}

}  // namespace

TEST_CASE("ClipMask: graphs count the transitions of the allowed clips", "[core][model]") {
  const core::Model model = SmallModel(20, 90, 3, 6, 5);
  for (const int count : {1, 2, 7, 19, 20}) {
    const auto mask = SomeClips(model, count, static_cast<unsigned>(count));
    for (int layer = 1; layer <= model.layer_count(); ++layer) {
      const auto expected = core::CountGlobalGraph(model.tree(), layer, ClipsOf(model, *mask));
      CHECK(mask->global_graph(layer).row_begin() == expected.row_begin());
      CHECK(mask->global_graph(layer).edges() == expected.edges());
    }
  }
}

TEST_CASE("ClipMask: frames are those of the allowed clips, in the tree's order", "[core][model]") {
  const core::Model model = SmallModel(12, 90, 3, 6, 7);
  const auto mask = SomeClips(model, 4, 3);
  for (std::size_t b = 0; b < model.tree().branches().size(); ++b) {
    std::vector<std::int32_t> expected;
    for (const std::int32_t frame : core::AllowedFrames(model, static_cast<int>(b), nullptr)) {
      if (mask->allows(model.clip_of_frame(frame))) expected.push_back(frame);
    }
    const auto frames = mask->frames(static_cast<int>(b));
    CHECK(std::vector<std::int32_t>(frames.begin(), frames.end()) == expected);
  }
  CHECK(mask->frames(0).size() == 4 * 90);
}

TEST_CASE("ClipMask: the index has the nodes and clips with allowed frames", "[core][model]") {
  const core::Model model = SmallModel(12, 90, 3, 6, 9);
  const auto mask = SomeClips(model, 3, 1);
  const core::ClipIndex& all = model.clip_index();
  int place = 0;
  for (int node = 0; node < all.node_count(); ++node) {
    std::vector<int> expected;
    for (const int clip : all.clips(node)) {
      if (mask->allows(clip)) expected.push_back(clip);
    }
    CHECK(core::IsAllowedNode(model, model.layer_count(), node, mask.get()) == !expected.empty());
    if (expected.empty()) continue;
    REQUIRE(place < mask->clip_index().node_count());
    const auto clips = mask->clip_index().clips(place);
    CHECK(std::vector<int>(clips.begin(), clips.end()) == expected);
    CHECK(mask->clip_index().means().row(place) == all.means().row(node));
    CHECK(mask->clip_index().squared_norms()[place] == all.squared_norms()[node]);
    ++place;
  }
  CHECK(place == mask->clip_index().node_count());
}

TEST_CASE("ClipMask: threads share one mask", "[core][model]") {
  const core::Model model = SmallModel(12, 90, 3, 6, 9);
  const auto mask = SomeClips(model, 5, 1);
  std::vector<const core::TransitionGraph*> graphs(16);
  std::vector<std::size_t> frames(16);
  RunOnThreads(4)(16, [&](int i) {
    graphs[i] = &mask->global_graph(2);
    frames[i] = mask->frames(0).size();
    mask->clip_index();
  });
  CHECK(std::set<const core::TransitionGraph*>(graphs.begin(), graphs.end()).size() == 1);
  CHECK(std::ranges::count(frames, 5 * 90) == 16);
}

TEST_CASE("ClipMask: refuses a mask without clips or of another size", "[core][model]") {
  const core::Model model = SmallModel(3, 60, 3, 6, 9);
  const auto none = core::ClipMask::Create(model, std::vector<bool>(3));
  CHECK(none.status().code() == absl::StatusCode::kFailedPrecondition);
  REQUIRE(none.status().GetPayload(core::kReasonUrl).has_value());
  CHECK(std::string(*none.status().GetPayload(core::kReasonUrl)) == "FILTER_MATCHES_NOTHING");
  CHECK(core::ClipMask::Create(model, std::vector<bool>(4, true)).status().code() ==
        absl::StatusCode::kInvalidArgument);
}

}  // namespace motiondb::tests::clip_mask_test
