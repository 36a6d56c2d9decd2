#include <catch2/catch.hpp>

#include "core/model/model_builder.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::extend_model_test {
namespace {

constexpr int kMarkers = 5;
constexpr int kFrames = 150;

std::vector<core::BuildInput> Clips(int first, int end) {
  auto clips = WanderingClips(end, kFrames, SmallMarkerSet(kMarkers), 4);
  clips.erase(clips.begin(), clips.begin() + first);
  return clips;
}

core::Model Built(int clips) {
  auto model = core::BuildModel({.min_frames = 8}, SmallMarkerSet(kMarkers), Clips(0, clips),
                                core::RunSerially, nullptr);
  REQUIRE(model.ok());
  return *std::move(model);
}

core::Model Extended(const core::Model& base, int first, int end) {
  auto model = core::ExtendModel(base, Clips(first, end), core::RunSerially);
  REQUIRE(model.ok());
  return *std::move(model);
}

}  // namespace

TEST_CASE("ExtendModel: equals a model whose tree was built with the clips", "[core][model]") {
  const core::Model base = Built(12);
  const core::Model model = Extended(base, 12, 14);
  REQUIRE(model.frame_count() == 14 * kFrames);
  REQUIRE(model.clips().size() == 14);
  CHECK(model.clips()[13].first_frame == 13 * kFrames);
  CHECK(model.built_clip_count() == 12);
  CHECK(model.built_frame_count() == 12 * kFrames);
  // The states are scaled by the scale of the base, in the given order.
  const auto added = Clips(12, 13);
  const Eigen::RowVectorXf seventh =
      added[0].states.states.row(7).cwiseQuotient(base.scale().divisor);
  CHECK(model.states().row(12 * kFrames + 7) == seventh);
  CHECK(model.root_path().row(12 * kFrames + 7) == added[0].states.root_path.row(7));
  for (int layer = 1; layer <= model.layer_count(); ++layer) {
    std::vector<std::vector<std::int32_t>> sequences;
    for (const core::ModelClip& clip : model.clips()) {
      auto& sequence = sequences.emplace_back();
      for (int f = 0; f < clip.frame_count; ++f) {
        sequence.push_back(model.tree().node_of_frame(layer, clip.first_frame + f));
      }
    }
    const core::TransitionGraph counted =
        core::CountTransitions(sequences, model.tree().node_count(layer));
    CHECK(model.global_graph(layer).edges() == counted.edges());
    CHECK(model.global_graph(layer).row_begin() == counted.row_begin());
    for (int c = 0; c < 14; ++c) {
      const core::ClipGraph own = core::CountClipTransitions(sequences[c]);
      const auto graph = model.clip_graph(layer, c);
      CHECK(graph->nodes == own.nodes);
      CHECK(graph->frames == own.frames);
      CHECK(graph->transitions.row_begin() == own.transitions.row_begin());
      CHECK(graph->transitions.edges() == own.transitions.edges());
    }
  }
  // The metric frames equal those of a model created from the same parts.
  const auto recreated = core::Model::Create(model.parts());
  REQUIRE(recreated.ok());
  CHECK(model.metric_frames().rows.frame == recreated->metric_frames().rows.frame);
  CHECK((model.metric_frames().projected.view() - recreated->metric_frames().projected.view())
            .cwiseAbs()
            .maxCoeff() < 1e-5);
  CHECK(model.clip_index().clips(0).size() == recreated->clip_index().clips(0).size());
}

TEST_CASE("ExtendModel: the model does not depend on the number of extensions", "[core][model]") {
  const core::Model base = Built(12);
  const core::Model in_one_step = Extended(base, 12, 14);
  const core::Model first = Extended(base, 12, 13);
  const core::Model second = Extended(first, 13, 14);
  CHECK(second.states() == in_one_step.states());
  CHECK(second.tree().frame_order() == in_one_step.tree().frame_order());
  CHECK(second.built_clip_count() == 12);
  for (int layer = 1; layer <= base.layer_count(); ++layer) {
    CHECK(second.global_graph(layer).edges() == in_one_step.global_graph(layer).edges());
  }
  CHECK((second.gaussians().means() - in_one_step.gaussians().means()).cwiseAbs().maxCoeff() <
        1e-5);
}

TEST_CASE("ExtendModel: does not change the base, also if it is extended twice", "[core][model]") {
  const core::Model base = Built(12);
  const core::FrameMatrix before = base.states();
  const core::Model extended = Extended(base, 12, 13);  // uses the spare capacity of the base
  const core::Model second_extended = Extended(base, 11, 12);     // the capacity is used
  const core::Model extended_twice = Extended(extended, 13, 14);  // the capacity is too small
  CHECK(base.states() == before);
  CHECK(base.frame_count() == 12 * kFrames);
  CHECK(extended.states().data() == base.states().data());
  CHECK(second_extended.states().data() != base.states().data());
  CHECK(extended_twice.states().data() != extended.states().data());
  CHECK(extended.states().topRows(12 * kFrames) == before);
  CHECK(second_extended.states().topRows(12 * kFrames) == before);
  CHECK(extended_twice.states().topRows(13 * kFrames) == extended.states());
  CHECK(extended.states().bottomRows(kFrames) != second_extended.states().bottomRows(kFrames));
}

TEST_CASE("MeasureDrift: zero after a build, then the fraction of added frames", "[core][model]") {
  const core::Model base = Built(12);
  CHECK(core::MeasureDrift(base, core::RunSerially).added == 0);
  CHECK(core::MeasureDrift(base, core::RunSerially).stale == 0);
  CHECK_FALSE(core::MeasureDrift(base, core::RunSerially).IsLarge());
  const core::ModelDrift drift_of_one =
      core::MeasureDrift(Extended(base, 12, 13), core::RunSerially);
  CHECK(drift_of_one.added == Approx(1.0 / 13));
  const core::ModelDrift drift_of_two =
      core::MeasureDrift(Extended(base, 12, 14), core::RunSerially);
  CHECK(drift_of_two.added == Approx(2.0 / 14));
  CHECK(drift_of_two.IsLarge());
  CHECK(drift_of_two.stale >= drift_of_one.stale);
}

TEST_CASE("ExtendModel: rejects invalid input", "[core][model]") {
  const core::Model base = Built(3);
  const auto code = [&](std::vector<core::BuildInput> inputs) {
    return core::ExtendModel(base, std::move(inputs), core::RunSerially).status().code();
  };
  CHECK(code({}) == absl::StatusCode::kInvalidArgument);
  auto narrow = Clips(3, 4);
  narrow[0].states.states.conservativeResize(Eigen::NoChange, 6);
  CHECK(code(narrow) == absl::StatusCode::kInvalidArgument);
  auto nan = Clips(3, 4);
  nan[0].states.states(3, 3) = NAN;
  CHECK(code(nan) == absl::StatusCode::kInvalidArgument);
  // A model that an older version stored.
  core::ModelParts parts = base.parts();
  parts.tree = *core::Tree::Create(parts.tree.frame_order(), parts.tree.branches());
  const auto old_model = core::Model::Create(std::move(parts));
  REQUIRE(old_model.ok());
  CHECK(core::ExtendModel(*old_model, Clips(3, 4), core::RunSerially).status().code() ==
        absl::StatusCode::kFailedPrecondition);
}

}  // namespace motiondb::tests::extend_model_test
