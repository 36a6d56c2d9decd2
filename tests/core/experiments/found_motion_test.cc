// What a search by shortlist misses, on recorded motion.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>

#include "core/format/marker_set_file.h"
#include "core/recognition/find_motion.h"
#include "tests/support/real_data.h"
#include "tests/support/real_motion.h"

namespace motiondb::tests::found_motion_test {
namespace {

constexpr double kRate = 60;
constexpr int kPieceFrames = 30;

// Clips of 0.5 s, more than a shortlist has.
std::vector<core::BuildInput> Pieces(const std::filesystem::path& list) {
  std::vector<core::BuildInput> pieces;
  for (const ListedClip& clip : ReadList(list)) {
    const core::StateSequence states = LoadStates(clip.path, kRate);
    for (int first = 0; first + kPieceFrames <= states.frame_count(); first += kPieceFrames) {
      core::BuildInput& piece = pieces.emplace_back();
      piece.clip_id = clip.path.stem().string() + "-" + std::to_string(first);
      piece.labels = clip.label;
      piece.states.frame_rate_hz = kRate;
      piece.states.leg_length_m = states.leg_length_m;
      piece.states.states = states.states.middleRows(first, kPieceFrames);
      piece.states.root_path = states.root_path.middleRows(first, kPieceFrames);
    }
  }
  return pieces;
}

}  // namespace

TEST_CASE("A search by shortlist finds what an exhaustive search finds", "[experiment][data]") {
  MOTIONDB_REQUIRE_DATA();
  auto pieces = Pieces(DataDir() / "sets" / "database1.train.tsv");
  const auto more = Pieces(DataDir() / "sets" / "database2.tsv");
  for (const core::BuildInput& piece : more) {
    const bool is_new = std::ranges::none_of(
        pieces, [&](const core::BuildInput& known) { return known.clip_id == piece.clip_id; });
    if (is_new) pieces.push_back(piece);
  }
  const auto model =
      core::BuildModel({}, core::StandardScheme().set, pieces, core::RunSerially, {});
  REQUIRE(model.ok());
  int found = 0;
  int all = 0;
  int first = 0;
  int searches = 0;
  for (const ListedClip& clip : ReadList(DataDir() / "sets" / "database1.test.tsv")) {
    const auto states = LoadStates(clip.path, kRate, core::kObservation);
    for (double start = 0; (start + 0.4) * kRate < states.frame_count(); start += 1) {
      const auto motion = core::PartOfObservation(*model, states, {start, start + 0.4});
      REQUIRE(motion.ok());
      const auto fast = core::FindMotion(*model, *motion, {});
      const auto exhaustive = core::FindMotion(*model, *motion, {.exhaustive = true});
      REQUIRE(fast.ok());
      REQUIRE(exhaustive.ok());
      ++searches;
      first += fast->front().clip == exhaustive->front().clip;
      for (const core::MotionMatch& match : *exhaustive) {
        ++all;
        found += std::ranges::any_of(*fast, [&](const core::MotionMatch& other) {
          return other.clip == match.clip && other.first_frame == match.first_frame &&
                 other.frame_count == match.frame_count && other.score == match.score;
        });
      }
    }
  }
  std::printf("find in %zu clips: %d of %d best matches, %d of %d of the best ten\n", pieces.size(),
              first, searches, found, all);
  CHECK(pieces.size() > 256);
  CHECK(first >= 0.99 * searches);
  CHECK(found >= 0.97 * all);
}

}  // namespace motiondb::tests::found_motion_test
