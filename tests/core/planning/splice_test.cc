#include "core/planning/splice.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/planning/segment_graph.h"
#include "core/planning/synthesis.h"
#include "tests/core/planning/walking_database.h"

namespace motiondb::core::splice_test {
namespace {

using tests::WalkingDatabase;

constexpr double kLeg = tests::WalkingFigure::kLeg_m;

// A path of three runs with joins of the graph, which leave room for more.
SplicedPath PathOfThreeRuns(SegmentGraph& graph) {
  const Model& model = WalkingDatabase();
  SplicedPath path{.start = 20};
  int since = path.start;  // first frame of the current run
  for (int run = graph.run_of_frame(since); path.joins.size() < 2;) {
    const auto& joins = graph.Joins(run);
    const auto fits = std::find_if(joins.begin(), joins.end(), [&](const RunJoin& join) {
      const ModelClip& clip = model.clips()[model.clip_of_frame(join.join.enter)];
      return join.join.leave >= since + 2 * graph.half_window() &&
             join.join.enter + 100 < clip.first_frame + clip.frame_count;
    });
    if (fits == joins.end()) {
      REQUIRE(graph.runs()[run].continues);
      ++run;
      continue;
    }
    path.joins.push_back(fits->join);
    since = fits->join.enter + 1;
    run = fits->to;
  }
  path.end = since + 30;
  return path;
}

TEST_CASE("Splice: frames match root poses, and joins match the search's values", "[planning]") {
  const Model& model = WalkingDatabase();
  const StoredFloor floor(model, kLeg);
  SegmentGraph graph(model, floor, model.layer_count(), {});
  const SplicedPath path = PathOfThreeRuns(graph);
  const auto played = PlayedFrames(path);
  const auto root = PlayedRoot(floor, path);
  REQUIRE(played.size() == root.size());

  // The end as the search computes it: along a clip, across a join, along a clip.
  FloorPose end;
  int at = path.start;
  for (const Join& join : path.joins) {
    end = end * floor.Between(at, join.leave - join.half_window) * AcrossJoin(floor, join);
    at = join.enter + join.half_window;
  }
  end = end * floor.Between(at, path.end);
  CHECK(end.x == Approx(root.back().x));
  CHECK(end.y == Approx(root.back().y));
  CHECK(end.heading == Approx(root.back().heading));
}

TEST_CASE("Splice: one run fades into the next; outside the join only one run counts",
          "[planning]") {
  const SplicedPath path{.start = 10, .joins = {{30, 100, 5}}, .end = 120};
  const auto played = PlayedFrames(path);
  REQUIRE(played.size() == 21U + 20U);
  CHECK(played.front().main == 10);
  CHECK(played.back().main == 120);
  double entering = 0;
  for (std::size_t t = 0; t < played.size(); ++t) {
    CHECK(played[t].share >= 0);
    CHECK(played[t].share <= 0.5 + 1e-12);
    const double now = played[t].main >= 96    ? 1 - played[t].share
                       : played[t].fading >= 0 ? played[t].share
                                               : 0;
    CHECK(now >= entering - 1e-12);
    entering = now;
  }
  CHECK(played[20].main == 30);
  CHECK(played[20].fading == 100);
  CHECK(played[20].share == Approx(0.5));
  CHECK(played[25].main == 105);
  CHECK(played[25].share == Approx(0).margin(1e-12));
}

TEST_CASE("Segment graph: a join connects similar states of one node, in allowed clips",
          "[planning]") {
  const Model& model = WalkingDatabase();
  const StoredFloor floor(model, kLeg);
  const int layer = model.layer_count() - 1;
  SegmentGraph graph(model, floor, layer, {.labels = {"bend"}});
  int joins = 0;
  for (std::size_t r = 0; r < graph.runs().size(); ++r) {
    for (const RunJoin& join : graph.Joins(static_cast<int>(r))) {
      ++joins;
      const auto& [leave, enter, window] = join.join;
      CHECK(model.tree().node_of_frame(layer, leave) == model.tree().node_of_frame(layer, enter));
      CHECK(graph.run_of_frame(leave) == static_cast<int>(r));
      CHECK(graph.run_of_frame(enter) == join.to);
      for (const int frame : {leave - window, leave + window}) {
        CHECK(model.clip_of_frame(frame) == model.clip_of_frame(leave));
      }
      for (const int frame : {enter - window, enter + window}) {
        CHECK(model.clip_of_frame(frame) == model.clip_of_frame(enter));
        CHECK(model.clips()[model.clip_of_frame(frame)].label() == "bend");
      }
    }
  }
  CHECK(joins > 20);
  CHECK(graph.run_of_frame(0) == -1);  // of the clip "straight"
}

TEST_CASE("Synthesis: no jump at a join, in place or speed", "[planning]") {
  const Model& model = WalkingDatabase();
  const StoredFloor floor(model, kLeg);
  SegmentGraph graph(model, floor, model.layer_count(), {});
  const SplicedPath path = PathOfThreeRuns(graph);
  const auto origin = FindOrigins(model, {.clip = ClipMoment{"straight", 20 / 60.0}}, {});
  REQUIRE(origin.ok());
  const SynthesisedMotion motion =
      Synthesise(model, Body::OfSize(model, kLeg), origin->front(), path, PlayedRoot(floor, path));
  const FrameMatrix& p = motion.markers.positions_m;
  REQUIRE(p.rows() == static_cast<Eigen::Index>(PlayedFrames(path).size()));
  // The largest change of speed between frames of the stored clips.
  float stored = 0;
  const auto& straight = tests::WalkingFigure{}.Motion().positions_m;
  for (Eigen::Index t = 2; t < straight.rows(); ++t) {
    stored = std::max(
        stored,
        (straight.row(t) - 2 * straight.row(t - 1) + straight.row(t - 2)).cwiseAbs().maxCoeff());
  }
  for (Eigen::Index t = 2; t < p.rows(); ++t) {
    CHECK((p.row(t) - 2 * p.row(t - 1) + p.row(t - 2)).cwiseAbs().maxCoeff() < 2 * stored);
  }
}

}  // namespace
}  // namespace motiondb::core::splice_test
