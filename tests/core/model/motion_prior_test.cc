#include "core/model/motion_prior.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/model/model.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::motion_prior_test {
namespace {

// Returns clips whose markers swing like pendulums. Their future is linear in their past.
std::vector<core::BuildInput> Swinging(const core::MarkerSet& set, double phase) {
  auto inputs = WanderingClips(2, 400, set, 1);
  for (core::BuildInput& input : inputs) {
    phase += 1;
    for (Eigen::Index t = 0; t < 400; ++t) {
      for (Eigen::Index d = 0; d < input.states.states.cols() / 2; ++d) {
        const double angle = phase + 0.4 * static_cast<double>(d) + 3 * static_cast<double>(t) / 60;
        input.states.states(t, 6 * (d / 3) + d % 3) = static_cast<float>(0.3 * std::sin(angle));
        input.states.states(t, 6 * (d / 3) + d % 3 + 3) = static_cast<float>(0.9 * std::cos(angle));
      }
      input.states.root_path.row(t).setZero();
    }
  }
  return inputs;
}

}  // namespace

TEST_CASE("MotionPrior: finds a linear motion model", "[core][model]") {
  const core::MarkerSet set = SmallMarkerSet(4);
  const auto model = core::BuildModel({}, set, Swinging(set, 0), core::RunSerially, {});
  REQUIRE(model.ok());
  REQUIRE(model->prior().seconds.size() == 6);
  const core::StateSequence unseen = Swinging(set, 0.5)[0].states;
  const core::Track track(unseen);
  for (const double seconds : {0.08, 0.2, 0.4}) {
    double squares = 0;
    double squares_without_prior = 0;
    for (int frame = 60; frame < 300; frame += 7) {
      const core::FrameMatrix history = core::HistoryAt(track, frame);
      const Eigen::RowVectorXf moved = track.SeenFrom(frame, seconds * 60) - history.row(0);
      squares += (model->prior().Displacement(core::MotionFeatures(history), seconds) - moved)
                     .squaredNorm();
      squares_without_prior += moved.squaredNorm();
    }
    CHECK(squares < 0.1 * squares_without_prior);
  }
}

TEST_CASE("MotionPrior: independent of the execution order; empty for short clips",
          "[core][model]") {
  const core::MarkerSet set = SmallMarkerSet(4);
  const core::ParallelFor backwards = [](int count, const std::function<void(int)>& body) {
    for (int i = count; i-- > 0;) body(i);
  };
  const auto model = core::BuildModel({}, set, Swinging(set, 0), core::RunSerially, {});
  const auto again = core::BuildModel({}, set, Swinging(set, 0), backwards, {});
  CHECK(model->prior().weights == again->prior().weights);
  const auto short_clips_model =
      core::BuildModel({}, set, WanderingClips(2, 60, set, 1), core::RunSerially, {});
  CHECK(short_clips_model->prior().seconds.empty());
  CHECK(short_clips_model->prior().Displacement(Eigen::RowVectorXf::Ones(120), 0.4).isZero());
}

// Regression test: Eigen divides by the size of an update, so an empty update crashed.
TEST_CASE("MotionPrior: exists for any number of moments", "[core][model]") {
  const core::MarkerSet set = SmallMarkerSet(4);
  int fitted = 0;
  for (int frames = 83; frames < 100; ++frames) {
    const auto model =
        core::BuildModel({}, set, WanderingClips(1, frames, set, 1), core::RunSerially, {});
    REQUIRE(model.ok());
    fitted += model->prior().seconds.empty() ? 0 : 1;
  }
  CHECK(fitted > 8);
}

TEST_CASE("Track: poses between frames, before the first and after the last", "[core][model]") {
  core::StateSequence clip = WanderingClips(1, 50, SmallMarkerSet(3), 2)[0].states;
  clip.root_path.setRandom();
  const core::Track track(clip);
  const Eigen::RowVectorXf halfway = 0.5F * (track.SeenFrom(10, 3) + track.SeenFrom(10, 4));
  CHECK((track.SeenFrom(10, 3.5) - halfway).norm() < 1e-5);
  CHECK(track.SeenFrom(10, -30) == track.SeenFrom(10, -10));
  CHECK(track.SeenFrom(10, 300) == track.SeenFrom(10, 39));
  // A pose relative to its own frame equals the positions of its state.
  CHECK((track.SeenFrom(7, 0).head<3>() - clip.states.row(7).head<3>()).norm() < 1e-6);
  // The same world position, relative to two frames.
  const core::FrameMatrix world = core::WorldPositions(clip);
  core::StateSequence there = clip;
  there.states.row(5).head<3>() = track.SeenFrom(5, 20).head<3>();
  CHECK((core::WorldPositions(there).row(5).head<3>() - world.row(25).head<3>()).norm() < 1e-4);
}

TEST_CASE("RigidTree: keeps lengths and directions of bones, positions of other markers",
          "[core][model]") {
  const core::MarkerSet set = SmallMarkerSet(4);
  auto inputs = WanderingClips(2, 200, set, 3);
  for (core::BuildInput& input : inputs) {
    for (Eigen::Index t = 0; t < 200; ++t) {
      const double angle = 0.05 * static_cast<double>(t);
      const Eigen::RowVector3f direction(static_cast<float>(std::cos(angle)),
                                         static_cast<float>(std::sin(angle)), 0);
      auto row = input.states.states.row(t);
      row.segment<3>(6) = row.segment<3>(0) + 0.5F * direction;
    }
  }
  const auto model = core::BuildModel({}, set, std::move(inputs), core::RunSerially, {});
  REQUIRE(model.ok());
  const core::RigidTree& tree = model->rigid_tree();
  REQUIRE(tree.bones.size() == 4);
  int bones = 0;
  for (const auto& bone : tree.bones) bones += bone.parent >= 0;
  CHECK(bones == 1);
  const Eigen::RowVectorXf reference = Eigen::RowVectorXf::Random(12);
  const Eigen::RowVectorXf predicted = Eigen::RowVectorXf::Random(12);
  const Eigen::RowVectorXf restored = tree.Restore(predicted, reference);
  const auto length = [](const Eigen::RowVectorXf& pose) {
    return (pose.segment<3>(3) - pose.segment<3>(0)).norm();
  };
  CHECK(length(restored) == Approx(length(reference)));
  CHECK((restored.tail<6>() - predicted.tail<6>()).isZero());
  CHECK(tree.Restore(reference, reference).isApprox(reference, 1e-5F));
}

}  // namespace motiondb::tests::motion_prior_test
