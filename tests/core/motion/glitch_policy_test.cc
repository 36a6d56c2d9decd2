#include <catch2/catch.hpp>
#include <cmath>

#include "core/motion/glitches.h"
#include "core/motion/states.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::glitch_policy_test {
namespace {

using Catch::Matchers::Contains;
using core::GlitchPolicy;

constexpr int kFrames = 240;

// Hips, knee and ankle that sway while they move along x, at 120 Hz.
core::MarkerMotion Sway() {
  core::MarkerMotion motion{{"m0", "m1", "m2", "m3"}, 120, core::FrameMatrix(kFrames, 12)};
  const Eigen::Vector3d body[] = {{0, 0.1, 0.9}, {0, -0.1, 0.9}, {0.05, 0.1, 0.5}, {0, 0.1, 0.1}};
  for (int t = 0; t < kFrames; ++t) {
    for (int m = 0; m < 4; ++m) {
      const Eigen::Vector3d p =
          body[m] + Eigen::Vector3d(t / 120.0, 0.1 * std::sin(t / 20.0), 0.02 * std::cos(t / 9.0));
      motion.positions_m.row(t).segment<3>(3 * m) = p.cast<float>().transpose();
    }
  }
  return motion;
}

// Moves all markers 100 m away in some frames, numbered from 0.
core::MarkerMotion Displaced(const std::vector<core::FrameSpan>& spans) {
  core::MarkerMotion motion = Sway();
  for (const core::FrameSpan& span : spans) {
    motion.positions_m.middleRows(span.first, span.last - span.first + 1).array() += 100;
  }
  return motion;
}

struct Stored {
  absl::StatusOr<core::StateSequence> states;
  std::string note;
};

Stored Store(GlitchPolicy policy, const core::MarkerMotion& motion) {
  const core::MarkerScheme scheme{SmallMarkerSet(4), {}};
  std::vector<std::string> notes;
  Stored stored{core::Represent(scheme, motion, 60, policy, std::nullopt, &notes), ""};
  for (const std::string& note : notes) {
    if (note.starts_with(core::kGlitchNote)) stored.note = note;
  }
  return stored;
}

}  // namespace

TEST_CASE("Represent: a clip without glitches is unchanged by every policy, without a note",
          "[motion][glitches]") {
  const core::StateSequence states = *Store(GlitchPolicy::kKeep, Sway()).states;
  for (const auto policy : {GlitchPolicy::kRepair, GlitchPolicy::kReject, GlitchPolicy::kDrop}) {
    const Stored stored = Store(policy, Sway());
    REQUIRE(stored.states.ok());
    CHECK(stored.states->states == states.states);
    CHECK(stored.note.empty());
    CHECK(stored.states->glitches.empty());
  }
}

TEST_CASE("Represent: repair interpolates up to a quarter of a second", "[motion][glitches]") {
  const core::StateSequence clean = *Store(GlitchPolicy::kKeep, Sway()).states;
  for (const core::FrameSpan span : {core::FrameSpan{100, 100}, {0, 3}, {236, 239}, {100, 129}}) {
    INFO(span.first << " to " << span.last);
    const Stored stored = Store(GlitchPolicy::kRepair, Displaced({span}));
    INFO(stored.states.status());
    REQUIRE(stored.states.ok());
    CHECK_THAT(stored.note, Contains("repaired") && Contains("all markers jump") &&
                                Contains("frame") && Contains(std::to_string(span.first + 1)));
    CHECK(stored.states->glitches.empty());
    CHECK((stored.states->root_path - clean.root_path).cwiseAbs().maxCoeff() < 0.06);
    core::MarkerMotion again{{"m0", "m1", "m2", "m3"}, 60, core::WorldPositions(*stored.states)};
    CHECK(core::FindGlitches(again, stored.states->leg_length_m).empty());
  }
}

TEST_CASE("Represent: repair refuses a longer glitch with its position", "[motion][glitches]") {
  const Stored stored = Store(GlitchPolicy::kRepair, Displaced({{100, 130}}));
  CHECK(stored.states.status().code() == absl::StatusCode::kInvalidArgument);
  CHECK_THAT(std::string(stored.states.status().message()),
             Contains("frames 101-131") && Contains("all markers") && Contains("0.25 s"));
}

TEST_CASE("Represent: reject refuses every glitch with its position", "[motion][glitches]") {
  core::MarkerMotion motion = Sway();
  motion.positions_m(100, 9) += 1;
  const Stored stored = Store(GlitchPolicy::kReject, motion);
  CHECK(stored.states.status().code() == absl::StatusCode::kInvalidArgument);
  CHECK_THAT(std::string(stored.states.status().message()),
             Contains("frame 101") && Contains("'m3'"));
}

TEST_CASE("Represent: drop stores the longest section without glitches", "[motion][glitches]") {
  const Stored stored = Store(GlitchPolicy::kDrop, Displaced({{60, 60}, {190, 220}}));
  REQUIRE(stored.states.ok());
  CHECK_THAT(stored.note, Contains("dropped, frames 62-190 of 240 stored") && Contains("frame 61"));
  CHECK(stored.states->frame_count() == 65);  // 129 frames at half the rate
  CHECK(stored.states->root_path(0, 0) == Approx(61 / 120.0).margin(1e-3));
  CHECK(stored.states->glitches.empty());
}

TEST_CASE("Represent: keep stores the clip unchanged and records the frames",
          "[motion][glitches]") {
  const Stored stored = Store(GlitchPolicy::kKeep, Displaced({{100, 100}, {160, 219}}));
  REQUIRE(stored.states.ok());
  CHECK_THAT(stored.note, Contains("kept") && Contains("frame 101") && Contains("frames 161-220"));
  CHECK(stored.states->root_path(50, 0) > 100);
  REQUIRE(stored.states->glitches.size() == 2);
  // All frames that differ from the clean clip are recorded.
  const core::StateSequence clean = *Store(GlitchPolicy::kKeep, Sway()).states;
  for (int t = 0; t < clean.frame_count(); ++t) {
    const bool differs = !stored.states->states.row(t).isApprox(clean.states.row(t), 1e-3F) ||
                         std::abs(stored.states->root_path(t, 0) - clean.root_path(t, 0)) > 1e-3;
    const bool known = std::ranges::any_of(stored.states->glitches, [&](const auto& span) {
      return span.first <= t && t <= span.last;
    });
    INFO(t);
    CHECK((!differs || known));
  }
}

TEST_CASE("Represent: a huge position in the first frame does not affect the others",
          "[motion][glitches]") {
  const core::StateSequence clean = *Store(GlitchPolicy::kKeep, Sway()).states;
  for (const float huge : {1e6F, 1e30F}) {
    core::MarkerMotion motion = Sway();
    motion.positions_m.row(0).setConstant(huge);
    const Stored repaired = Store(GlitchPolicy::kRepair, motion);
    INFO(repaired.states.status());
    REQUIRE(repaired.states.ok());
    CHECK(repaired.states->states.bottomRows(100).isApprox(clean.states.bottomRows(100), 1e-4F));
    CHECK(Store(GlitchPolicy::kKeep, motion).states.status().code() ==
          absl::StatusCode::kInvalidArgument);
  }
}

TEST_CASE("Represent: an observation is not searched for glitches", "[motion][glitches]") {
  const core::MarkerScheme scheme{SmallMarkerSet(4), {}};
  const auto states = core::Represent(scheme, Displaced({{100, 130}}), 60, core::kObservation);
  REQUIRE(states.ok());
  CHECK(states->root_path(55, 0) > 100);
  CHECK(states->glitches.empty());
}

}  // namespace motiondb::tests::glitch_policy_test
