#include "tests/bench/varied_motion.h"

#include <catch2/catch.hpp>
#include <set>

#include "tests/support/real_data.h"
#include "tests/support/threads.h"

namespace motiondb::tests::varied_motion_test {
namespace {

constexpr VariedSize kSize{.clips = 700, .frames = 70'000};

std::vector<core::BuildInput> Clips(const VariedSize& size, std::uint64_t seed, int threads = 2) {
  auto clips = VariedClips(DataDir(), size, seed, RunOnThreads(threads));
  INFO(clips.status());
  REQUIRE(clips.ok());
  return *std::move(clips);
}

}  // namespace

TEST_CASE("Varied motion: the requested number of clips and frames, all finite", "[bench]") {
  MOTIONDB_REQUIRE_DATA();
  const std::vector<core::BuildInput> clips = Clips(kSize, 1);
  REQUIRE(clips.size() == 700);
  int frames = 0;
  std::set<std::string> ids, labels;
  for (const core::BuildInput& clip : clips) {
    frames += clip.states.frame_count();
    ids.insert(clip.clip_id);
    labels.insert(clip.label());
    REQUIRE(clip.states.states.cols() == 204);
    REQUIRE(clip.states.root_path.rows() == clip.states.states.rows());
    REQUIRE(clip.states.states.allFinite());
    REQUIRE(clip.states.root_path.allFinite());
  }
  CHECK(frames == 70'000);
  CHECK(ids.size() == clips.size());
  CHECK(labels.size() > 10);
}

TEST_CASE("Varied motion: depends on the seed, not on threads", "[bench]") {
  MOTIONDB_REQUIRE_DATA();
  const VariedSize size{.clips = 40, .frames = 4000};
  const std::vector<core::BuildInput> clips = Clips(size, 7, 1);
  const std::vector<core::BuildInput> again = Clips(size, 7, 2);
  const std::vector<core::BuildInput> other = Clips(size, 8);
  for (std::size_t c = 0; c < clips.size(); ++c) {
    CHECK(clips[c].label() == again[c].label());
    CHECK(clips[c].states.states == again[c].states.states);
    CHECK(clips[c].states.root_path == again[c].states.root_path);
    CHECK_FALSE(clips[c].states.states.row(0).isApprox(other[c].states.states.row(0), 1e-3f));
  }
}

TEST_CASE("Varied motion: velocities agree with positions", "[bench]") {
  MOTIONDB_REQUIRE_DATA();
  for (const core::BuildInput& clip : Clips({.clips = 20, .frames = 2000}, 3)) {
    const core::StateSequence& states = clip.states;
    const core::FrameMatrix world = core::WorldPositions(states);
    for (int t = 1; t + 1 < states.frame_count(); ++t) {
      for (int m = 0; m < 34; ++m) {
        Eigen::Vector3d velocity =
            ((world.row(t + 1) - world.row(t - 1)).segment<3>(3 * m).cast<double>() *
             states.frame_rate_hz / 2 / states.leg_length_m)
                .transpose();
        velocity.head<2>() = Eigen::Rotation2Dd(-states.root_path(t, 2)) * velocity.head<2>();
        const Eigen::Vector3d stored =
            states.states.row(t).segment<3>(6 * m + 3).cast<double>().transpose();
        REQUIRE((stored - velocity).norm() < 1e-3 * (1 + velocity.norm()));
      }
    }
  }
}

TEST_CASE("Varied motion: joins are as smooth as the recordings", "[bench]") {
  MOTIONDB_REQUIRE_DATA();
  // Recorded markers stay below 40 leg lengths per second, varied speed included.
  for (const core::BuildInput& clip : Clips({.clips = 300, .frames = 60'000}, 5)) {
    INFO(clip.clip_id << " " << clip.label());
    for (int m = 0; m < 34; ++m) {
      REQUIRE(clip.states.states.middleCols<3>(6 * m + 3).rowwise().norm().maxCoeff() < 40);
    }
  }
}

TEST_CASE("Varied motion: clips from one recording differ in every frame", "[bench]") {
  MOTIONDB_REQUIRE_DATA();
  const std::vector<core::BuildInput> clips = Clips(kSize, 1);
  // The next clip from the same recording as clip 0: one round of recordings later.
  std::size_t same = 1;
  const auto alike = [&](std::size_t c) {
    return clips[c].label() == clips[0].label() && clips[c].subject == clips[0].subject;
  };
  while (same < clips.size() && !(same > 100 && alike(same))) ++same;
  REQUIRE(same < clips.size());
  const core::FrameMatrix& a = clips[0].states.states;
  const core::FrameMatrix& b = clips[same].states.states;
  for (Eigen::Index t = 0; t < a.rows(); ++t) {
    CHECK((b.rowwise() - a.row(t)).rowwise().norm().minCoeff() > 0.05f);
  }
}

TEST_CASE("Varied motion: states in one matrix are scaled to unit spread", "[bench]") {
  MOTIONDB_REQUIRE_DATA();
  const auto states = VariedStates(DataDir(), {.clips = 20, .frames = 2000}, 3, RunOnThreads(2));
  REQUIRE(states.ok());
  REQUIRE(states->rows() == 2000);
  REQUIRE(states->cols() == 204);
  double variance = 0;
  for (Eigen::Index d = 0; d < 204; ++d) {
    const Eigen::VectorXd column = states->col(d).cast<double>();
    variance += (column.array() - column.mean()).square().mean() / 204;
  }
  CHECK(variance == Approx(1).epsilon(1e-3));
}

TEST_CASE("Varied motion: refuses clips that are too short", "[bench]") {
  const auto clips = VariedClips(DataDir(), {.clips = 100, .frames = 700}, 1, core::RunSerially);
  CHECK(clips.status().code() == absl::StatusCode::kInvalidArgument);
}

}  // namespace motiondb::tests::varied_motion_test
