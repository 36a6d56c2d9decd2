// Finding similar parts, compared with an exhaustive search in double precision.
#include "core/recognition/find_motion.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/model/clip_mask.h"
#include "core/recognition/cheapest_path.h"
#include "core/recognition/metric_observation.h"
#include "tests/support/some_clips.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::find_motion_test {
namespace {

constexpr int kFrames = 90;
constexpr int kManyClips = 300;  // more than a shortlist

std::vector<core::MotionMatch> Find(const core::Model& model, const core::FrameMatrix& motion,
                                    const core::FindOptions& options = {}) {
  auto matches = core::FindMotion(model, {motion}, options);
  INFO(matches.status());
  REQUIRE(matches.ok());
  return *std::move(matches);
}

core::FrameMatrix PartOf(const core::Model& model, int clip, int first, int count) {
  return model.states().middleRows(model.clips()[clip].first_frame + first, count);
}

// Changed so that it is in no clip.
core::FrameMatrix Unstored(const core::Model& model, int clip, int first, int count,
                           unsigned seed) {
  core::FrameMatrix motion = PartOf(model, clip, first, count);
  std::mt19937 random(seed);
  std::normal_distribution<float> normal(0, 0.1F);
  for (float& number : motion.reshaped()) number += normal(random);
  return motion;
}

// Compares all frames of all allowed clips: the cheapest path to each frame, one row at a time;
// then the disjoint ones, of all pairs.
std::vector<core::MotionMatch> SearchAll(const core::Model& model, const core::FrameMatrix& motion,
                                         const core::ClipMask* mask, int top_count) {
  const Eigen::MatrixXd projection = model.metric().projection.cast<double>();
  const Eigen::MatrixXd observed = motion.cast<double>() * projection;
  std::vector<core::MotionMatch> matches;
  for (const int clip : core::AllowedClips(model, mask)) {
    const int frames = model.clips()[clip].frame_count;
    const Eigen::MatrixXd stored = PartOf(model, clip, 0, frames).cast<double>() * projection;
    std::vector<std::pair<double, int>> paths(frames);  // cost and first frame
    for (int t = 0; t < observed.rows(); ++t) {
      std::vector<std::pair<double, int>> next(frames);
      for (int f = 0; f < frames; ++f) {
        std::pair<double, int> best = {0, f};
        if (t > 0) {
          best = {paths[f].first + core::kWarpCost, paths[f].second};
          if (f > 0) best = std::min(best, paths[f - 1]);
          if (f > 1) {
            best = std::min(best, {paths[f - 2].first + core::kWarpCost, paths[f - 2].second});
          }
        }
        best.first += (observed.row(t) - stored.row(f)).squaredNorm();
        next[f] = best;
      }
      paths = next;
    }
    std::vector<bool> is_taken(frames);
    while (true) {
      int end = -1;
      for (int f = 0; f < frames; ++f) {
        const bool is_free =
            std::none_of(is_taken.begin() + paths[f].second, is_taken.begin() + f + 1,
                         [](bool taken) { return taken; });
        if (is_free && (end < 0 || paths[f].first < paths[end].first)) end = f;
      }
      if (end < 0) break;
      const auto [cost, first] = paths[end];
      std::fill(is_taken.begin() + first, is_taken.begin() + end + 1, true);
      const double mean = cost / static_cast<double>(observed.rows());
      matches.push_back({clip, first, end - first + 1,
                         1 / (1 + mean / (2 * static_cast<double>(projection.cols())))});
    }
  }
  std::ranges::stable_sort(matches, std::greater<>(), &core::MotionMatch::score);
  matches.resize(std::min<std::size_t>(matches.size(), top_count));
  return matches;
}

// Matches with nearly equal scores may be in another order.
void CheckEqual(const std::vector<core::MotionMatch>& found,
                const std::vector<core::MotionMatch>& expected) {
  REQUIRE(found.size() == expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    CHECK(found[i].score == Approx(expected[i].score).epsilon(1e-4));
    CHECK(std::ranges::any_of(expected, [&](const core::MotionMatch& match) {
      return match.clip == found[i].clip && match.first_frame == found[i].first_frame &&
             match.frame_count == found[i].frame_count &&
             std::abs(match.score - found[i].score) < 1e-4;
    }));
  }
}

}  // namespace

TEST_CASE("FindMotion: equals an exhaustive search", "[core][recognition]") {
  const core::Model model = SmallModel(12, kFrames, 3, 6, 5);
  for (unsigned seed = 0; seed < 12; ++seed) {
    const int count = 1 + static_cast<int>(seed * 5 % 31);
    const core::FrameMatrix motion =
        Unstored(model, static_cast<int>(seed), static_cast<int>(seed), count, seed);
    const std::vector<core::MotionMatch> found = Find(model, motion, {.top_count = 30});
    // All clips are compared, because they are few.
    CheckEqual(found, SearchAll(model, motion, nullptr, 30));
    CheckEqual(Find(model, motion, {.top_count = 30, .exhaustive = true}), found);
  }
}

TEST_CASE("FindMotion: finds a stored part first, at its own times", "[core][recognition]") {
  const core::Model few = SmallModel(7, kFrames, 3, 6, 5);
  const core::Model many = SmallModel(kManyClips, kFrames, 3, 6, 5);
  for (const core::Model* const model : {&few, &many}) {
    for (int clip = 0; clip < std::ssize(model->clips()); clip += 5) {
      const int first = (7 * clip + 1) % 60;
      const int count = 2 + clip % 29;
      const auto best = Find(*model, PartOf(*model, clip, first, count)).front();
      CHECK(best.clip == clip);
      CHECK(best.first_frame == first);
      CHECK(best.frame_count == count);
      CHECK(best.score == Approx(1).margin(1e-3));
    }
  }
}

TEST_CASE("FindMotion: matches are ordered, and disjoint within a clip", "[core][recognition]") {
  const core::Model model = SmallModel(40, kFrames, 3, 6, 5);
  const auto matches = Find(model, Unstored(model, 3, 20, 15, 1), {.top_count = 200});
  CHECK(matches.size() > 60);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const core::MotionMatch& match = matches[i];
    CHECK(match.score > 0);
    CHECK(match.score < 1);
    CHECK(match.first_frame >= 0);
    CHECK(match.first_frame + match.frame_count <= kFrames);
    if (i > 0) CHECK(match.score <= matches[i - 1].score);
    for (std::size_t j = 0; j < i; ++j) {
      if (matches[j].clip != match.clip) continue;
      CHECK((matches[j].first_frame + matches[j].frame_count <= match.first_frame ||
             match.first_frame + match.frame_count <= matches[j].first_frame));
    }
  }
}

TEST_CASE("FindMotion: a mask has the result of a search in its clips", "[core][recognition]") {
  for (const int clips : {20, kManyClips}) {
    const core::Model model = SmallModel(clips, kFrames, 3, 6, 5);
    const core::FrameMatrix motion = Unstored(model, 4, 10, 20, 2);
    for (unsigned seed = 0; seed < 4; ++seed) {
      const auto mask = SomeClips(model, 9, seed);
      const auto found = Find(model, motion, {.top_count = 15, .mask = mask});
      CheckEqual(found, SearchAll(model, motion, mask.get(), 15));
    }
  }
}

TEST_CASE("FindMotion: does not depend on the order of the clips", "[core][recognition]") {
  const core::MarkerSet set = SmallMarkerSet(3);
  auto inputs = WanderingClips(24, kFrames, set, 8);
  core::BuildSettings settings;
  settings.min_frames = 6;
  const auto before = core::BuildModel(settings, set, inputs, core::RunSerially, {});
  std::shuffle(inputs.begin(), inputs.end(), std::mt19937(3));
  auto shuffled = core::BuildModel(settings, set, inputs, core::RunSerially, {});
  REQUIRE(before.ok());
  REQUIRE(shuffled.ok());
  // The metric is fitted in the order of the clips.
  core::ModelParts parts = (*std::move(shuffled)).TakeParts();
  parts.metric = before->metric();
  const auto after = core::Model::Create(std::move(parts));
  REQUIRE(after.ok());
  const core::FrameMatrix motion = Unstored(*before, 5, 30, 18, 4);
  const auto first = Find(*before, motion, {.top_count = 8});
  const auto second = Find(*after, motion, {.top_count = 8});
  REQUIRE(first.size() == second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    CHECK(before->clips()[first[i].clip].id == after->clips()[second[i].clip].id);
    CHECK(first[i].first_frame == second[i].first_frame);
    CHECK(first[i].frame_count == second[i].frame_count);
    CHECK(first[i].score == Approx(second[i].score).epsilon(1e-4));
  }
}

TEST_CASE("FindMotion: missing markers", "[core][recognition]") {
  constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();
  for (const int clips : {9, kManyClips}) {
    const core::Model model = SmallModel(clips, kFrames, 4, 6, 5);
    core::FrameMatrix motion = PartOf(model, 6, 21, 24);
    motion.middleCols(18, 6).setConstant(kMissing);  // one marker never seen
    auto best = Find(model, motion).front();
    CHECK(best.clip == 6);
    CHECK(best.first_frame == 21);
    CHECK(best.frame_count == 24);
    CHECK(best.score == Approx(1).margin(1e-3));

    motion = PartOf(model, 6, 21, 24);
    motion.block(5, 6, 3, 6).setConstant(kMissing);  // one not seen in some frames
    best = Find(model, motion).front();
    CHECK(best.clip == 6);
    CHECK(best.first_frame == 21);
    CHECK(best.score > 0.7);
  }
}

TEST_CASE("FindMotion: rejects wrong options and parts", "[core][recognition]") {
  const core::Model model = SmallModel(4, kFrames, 3, 6, 5);
  const auto message = [](const auto& result) { return std::string(result.status().message()); };
  for (const int top : {0, -1, core::kMaxMatches + 1}) {
    const auto result = core::FindMotion(model, {PartOf(model, 0, 0, 9)}, {.top_count = top});
    CHECK(absl::IsInvalidArgument(result.status()));
    CHECK_THAT(message(result), Catch::Contains("top_count"));
  }
  CHECK(core::PartOfClip(model, "clip2", {})->states.rows() == kFrames);
  CHECK(core::PartOfClip(model, "clip2", {0.5, 1.0})->states == PartOf(model, 2, 30, 30));
  CHECK(core::PartOfClip(model, "clip2", {0.5, 1.0})->clip == 2);
  CHECK(core::PartOfClip(model, "clip2", {0.5, 0.501})->states.rows() == 1);
  CHECK_THAT(message(core::PartOfClip(model, "clip9", {})), Catch::Contains("clip9"));
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double start : {-0.1, 1.6, kNan}) {
    CHECK_THAT(message(core::PartOfClip(model, "clip2", {start, {}})),
               Catch::Contains("start_seconds"));
  }
  for (const double end : {0.5, 0.2, 1.6, kNan}) {
    CHECK_THAT(message(core::PartOfClip(model, "clip2", {0.5, end})),
               Catch::Contains("end_seconds"));
  }
  const auto cancelled =
      core::FindMotion(model, {PartOf(model, 0, 0, 9).replicate(200, 1)}, {}, [] { return true; });
  CHECK(absl::IsCancelled(cancelled.status()));
}

}  // namespace motiondb::tests::find_motion_test
