// Maps of models: nodes, transitions and frames in the principal axes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/view/model_picture.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/model.grpc.pb.h"
#include "motiondb/v1/segment.grpc.pb.h"
#include "motiondb/v1/view.grpc.pb.h"
#include "server/engine/live_database.h"
#include "server/engine/model_lifecycle.h"
#include "tests/server/rpc/limited_server.h"
#include "tests/server/rpc/trained_server.h"
#include "tests/support/packed_floats.h"

namespace motiondb::tests::state_map_test {
namespace {

using Stub = v1::ViewService::Stub;
using grpc::StatusCode;

constexpr char kCurrent[] = "databases/db/models/current";

struct Map {
  grpc::Status status;
  v1::StateMapHeader header;
  v1::StateMapNodes nodes;
  v1::StateMapTransitions transitions;
  v1::StateMapPoints points;
  int messages = 0;
};

v1::ReadStateMapRequest MapRequest(int layer = 0, const std::string& clip = "", int points = 0) {
  v1::ReadStateMapRequest request;
  request.set_parent(kCurrent);
  if (layer != 0) request.set_layer(layer);
  request.set_clip(clip);
  request.set_max_points(points);
  return request;
}

Map ReadMap(TestServer& server, const v1::ReadStateMapRequest& request) {
  Map map;
  grpc::ClientContext context;
  const auto stub = server.NewStub<v1::ViewService>();
  const auto reader = stub->ReadStateMap(&context, request);
  v1::ReadStateMapResponse part;
  while (reader->Read(&part)) {
    CHECK(part.ByteSizeLong() <= 1 << 20);
    CHECK(part.has_header() == (map.messages++ == 0));
    if (part.has_header()) map.header = part.header();
    // Nodes before transitions, these before points.
    if (part.has_nodes()) CHECK(map.transitions.from_node_ids().empty());
    if (part.has_transitions()) CHECK(map.points.clips().empty());
    // Merging appends repeated fields, but replaces bytes.
    if (part.has_nodes()) {
      const std::string means = map.nodes.means() + part.nodes().means();
      const std::string axes = map.nodes.semi_axes() + part.nodes().semi_axes();
      map.nodes.MergeFrom(part.nodes());
      map.nodes.set_means(means);
      map.nodes.set_semi_axes(axes);
    }
    map.transitions.MergeFrom(part.transitions());
    if (part.has_points()) {
      const std::string positions = map.points.positions() + part.points().positions();
      map.points.MergeFrom(part.points());
      map.points.set_positions(positions);
    }
  }
  map.status = reader->Finish();
  INFO(map.status.error_message());
  if (map.status.ok()) {
    CHECK(map.header.node_count() == map.nodes.node_ids_size());
    CHECK(map.header.transition_count() == map.transitions.from_node_ids_size());
    CHECK(map.header.point_count() == map.points.clips_size());
  }
  return map;
}

server::SnapshotPointer SnapshotOf(TestServer& server) {
  const auto live = server.server().engine().FindDatabase("db");
  REQUIRE(live.ok());
  return (*live)->lifecycle().snapshot();
}

TEST_CASE("ReadStateMap: nodes have the statistics of their frames", "[server][view]") {
  TestServer& server = TrainedServer();
  const auto snapshot = SnapshotOf(server);
  const core::Model& model = snapshot->model;
  const auto axes = core::FindStateAxes(model.states());
  REQUIRE(axes.ok());
  core::NodeSummaries summaries(model, *axes);
  for (int layer = 1; layer <= model.layer_count(); ++layer) {
    const Map map = ReadMap(server, MapRequest(layer));
    REQUIRE(map.status.ok());
    CHECK(map.header.model_version() == 1);
    CHECK(map.header.layer() == layer);
    REQUIRE(map.header.nodes_per_layer_size() == model.layer_count());
    CHECK(map.header.nodes_per_layer(layer - 1) == map.nodes.node_ids_size());
    CHECK(map.header.clips(1) == "databases/db/clips/walk");
    CHECK(map.header.labels(1) == "walk");
    REQUIRE(map.header.variance_fractions_size() == 6);
    for (int i = 0; i < 6; ++i) {
      CHECK(map.header.variance_fractions(i) == Approx(axes->variance_fractions[i]));
    }
    CHECK(map.nodes.parent_ids_size() == (layer == 1 ? 0 : map.nodes.node_ids_size()));
    const auto means = Unpack(map.nodes.means());
    const auto semi_axes = Unpack(map.nodes.semi_axes());
    REQUIRE(means.size() == 3u * static_cast<std::size_t>(map.nodes.node_ids_size()));
    REQUIRE(semi_axes.size() == 3 * means.size());
    int frames = 0;
    for (int i = 0; i < map.nodes.node_ids_size(); ++i) {
      CHECK(map.nodes.node_ids(i) == i);
      if (layer > 1) CHECK(map.nodes.parent_ids(i) == model.tree().parent(layer, i));
      const core::NodeSummary expected = summaries.Summarize(layer, i);
      CHECK(map.nodes.frame_counts(i) == expected.frame_count);
      CHECK(map.nodes.main_clips(i) == expected.main_clip);
      CHECK(map.nodes.label_fractions(i) == expected.label_fraction);
      for (int k = 0; k < 3; ++k) CHECK(means[3 * i + k] == Approx(expected.mean[k]).margin(1e-5));
      for (int k = 0; k < 9; ++k) {
        CHECK(semi_axes[9 * i + k] == Approx(expected.semi_axes.data()[k]).margin(1e-5));
      }
      frames += expected.frame_count;
    }
    CHECK(frames == 360);
  }
  CHECK(ReadMap(server, MapRequest()).header.layer() == model.layer_count());
}

TEST_CASE("ReadStateMap: transitions are those of ListTransitions", "[server][view]") {
  TestServer& server = TrainedServer();
  const auto models = server.NewStub<v1::ModelService>();
  const int layers = SnapshotOf(server)->model.layer_count();
  for (const std::string clip : {"", "databases/db/clips/walk", "databases/db/clips/wave"}) {
    for (int layer = 1; layer <= layers; ++layer) {
      const Map map = ReadMap(server, MapRequest(layer, clip));
      REQUIRE(map.status.ok());
      v1::ListTransitionsRequest list;
      list.set_parent(kCurrent);
      list.set_layer(layer);
      list.set_clip(clip);
      list.set_page_size(10000);
      const auto listed = Ask(*models, &v1::ModelService::Stub::ListTransitions, list);
      REQUIRE(listed.status.ok());
      REQUIRE(map.transitions.from_node_ids_size() == listed.response.transitions_size());
      std::set<int> visited;
      for (int i = 0; i < listed.response.transitions_size(); ++i) {
        const v1::Transition& expected = listed.response.transitions(i);
        CHECK(map.transitions.from_node_ids(i) == expected.from_node_id());
        CHECK(map.transitions.to_node_ids(i) == expected.to_node_id());
        CHECK(map.transitions.probabilities(i) == Approx(expected.probability()));
        visited.insert({expected.from_node_id(), expected.to_node_id()});
      }
      // Of a clip, only the nodes that it visits; they are the ends of its transitions.
      if (clip.empty()) continue;
      CHECK(std::vector<int>(map.nodes.node_ids().begin(), map.nodes.node_ids().end()) ==
            std::vector<int>(visited.begin(), visited.end()));
    }
  }
}

TEST_CASE("ReadStateMap: points are frames in order", "[server][view]") {
  TestServer& server = TrainedServer();
  const auto snapshot = SnapshotOf(server);
  const core::Model& model = snapshot->model;
  const auto axes = core::FindStateAxes(model.states());
  REQUIRE(axes.ok());
  for (const int wanted : {0, 1, 100, 360, 100'000, 2'000'000'000}) {
    for (const std::string clip : {"", "databases/db/clips/walk"}) {
      const Map map = ReadMap(server, MapRequest(2, clip, wanted));
      REQUIRE(map.status.ok());
      const int frames = clip.empty() ? 360 : 120;
      REQUIRE(map.points.clips_size() == std::min(wanted, frames));
      const auto positions = Unpack(map.points.positions());
      REQUIRE(positions.size() == 3u * static_cast<std::size_t>(map.points.clips_size()));
      int last = -1;
      for (int i = 0; i < map.points.clips_size(); ++i) {
        const core::ModelClip& of = model.clips()[map.points.clips(i)];
        CHECK((clip.empty() || of.id == "walk"));
        CHECK(map.points.frames(i) < of.frame_count);
        const int frame = of.first_frame + map.points.frames(i);
        CHECK(frame > last);
        last = frame;
        CHECK(map.points.node_ids(i) == model.tree().node_of_frame(2, frame));
        for (int k = 0; k < 3; ++k) {
          CHECK(positions[3 * i + k] == Approx(axes->projections(frame, k)).margin(1e-5));
        }
      }
    }
  }
}

TEST_CASE("ReadStateMap: errors", "[server][view]") {
  TestServer& server = TrainedServer();
  const auto status = [&](const v1::ReadStateMapRequest& request) {
    const Map map = ReadMap(server, request);
    CHECK(map.messages == 0);
    return map.status;
  };
  CHECK(ViolatedFields(status(MapRequest(99))) == "layer");
  CHECK(ViolatedFields(status(MapRequest(-1))) == "layer");
  CHECK(ViolatedFields(status(MapRequest(1, "", -1))) == "max_points");
  CHECK(ViolatedFields(status(MapRequest(1, "walk"))) == "clip");
  CHECK(ViolatedFields(status(MapRequest(1, "databases/other/clips/walk"))) == "clip");
  CHECK(status(MapRequest(1, "databases/db/clips/none")).error_code() == StatusCode::NOT_FOUND);
  v1::ReadStateMapRequest request;
  CHECK(ViolatedFields(status(request)) == "parent");
  request.set_parent("databases/none/models/current");
  CHECK(status(request).error_code() == StatusCode::NOT_FOUND);
  request.set_parent("databases/empty/models/current");
  CHECK(status(request).error_code() == StatusCode::FAILED_PRECONDITION);
}

TEST_CASE("ReadStateMap: many callers at a time get the same map", "[server][view]") {
  TestServer server;
  server.CreateTrained("db");
  std::vector<std::string> maps(8);
  std::vector<std::thread> threads;
  for (std::string& map : maps) {
    threads.emplace_back([&] {
      grpc::ClientContext context;
      const auto stub = server.NewStub<v1::ViewService>();
      const auto reader = stub->ReadStateMap(&context, MapRequest(0, "", 50));
      v1::ReadStateMapResponse part;
      while (reader->Read(&part)) map += part.SerializeAsString();
      if (!reader->Finish().ok()) map.clear();
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::string& map : maps) {
    CHECK(!map.empty());
    CHECK(map == maps[0]);
  }
}

TEST_CASE("ReadStateMap: goes on if the database is deleted or changed meanwhile",
          "[server][view]") {
  TestServer server;
  server.CreateTrained("db");
  const Map before = ReadMap(server, MapRequest(0, "", 360));
  grpc::ClientContext context;
  const auto stub = server.NewStub<v1::ViewService>();
  const auto reader = stub->ReadStateMap(&context, MapRequest(0, "", 360));
  v1::ReadStateMapResponse part;
  REQUIRE(reader->Read(&part));
  CHECK(part.has_header());
  v1::DeleteDatabaseRequest request;
  request.set_name("databases/db");
  REQUIRE(Ask(*server.NewStub<v1::DatabaseService>(), &v1::DatabaseService::Stub::DeleteDatabase,
              request)
              .status.ok());
  int nodes = 0;
  int points = 0;
  while (reader->Read(&part)) {
    nodes += part.nodes().node_ids_size();
    points += part.points().clips_size();
  }
  CHECK(reader->Finish().ok());
  CHECK(nodes == before.header.node_count());
  CHECK(points == 360);
  CHECK(ReadMap(server, MapRequest()).status.error_code() == StatusCode::NOT_FOUND);
}

TEST_CASE("ReadStateMap: a client that gives up frees its call", "[server][view]") {
  TestServer server(With({.heavy = {1, 1}}));
  server.CreateTrained("db");
  for (int i = 0; i < 20; ++i) {
    grpc::ClientContext context;
    const auto stub = server.NewStub<v1::ViewService>();
    const auto reader = stub->ReadStateMap(&context, MapRequest(0, "", 360));
    v1::ReadStateMapResponse part;
    if (i % 2 == 0) reader->Read(&part);
    context.TryCancel();
    while (reader->Read(&part)) {
    }
    reader->Finish();
  }
  Map map;
  for (int tries = 0; tries < 100 && map.messages == 0; ++tries) {
    map = ReadMap(server, MapRequest());
    if (map.messages == 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  CHECK(map.status.ok());
}

TEST_CASE("ReadStateMap: new labels are in the map at once", "[server][view]") {
  TestServer server;
  server.CreateTrained("db");
  const auto before = ReadMap(server, MapRequest(1));
  REQUIRE(before.status.ok());
  CHECK(before.nodes.label_fractions(0) == Approx(1.0 / 3));
  const auto axes =
      SnapshotOf(server)->view->Axes(SnapshotOf(server)->model, core::RunSerially, {});
  REQUIRE(axes.ok());
  v1::ListSegmentsRequest list;
  list.set_parent("databases/db/clips/squat");
  const auto segments = server.NewStub<v1::SegmentService>();
  const auto listed = Ask(*segments, &v1::SegmentService::Stub::ListSegments, list);
  REQUIRE(listed.response.segments_size() == 1);
  v1::UpdateSegmentRequest update;
  *update.mutable_segment() = listed.response.segments(0);
  update.mutable_segment()->set_label("walk");
  update.mutable_update_mask()->add_paths("label");
  const auto updated = Ask(*segments, &v1::SegmentService::Stub::UpdateSegment, update);
  INFO(updated.status.error_message());
  REQUIRE(updated.status.ok());
  Map after;
  for (int tries = 0; tries < 500; ++tries) {
    after = ReadMap(server, MapRequest(1));
    if (after.header.labels(0) == "walk") break;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  CHECK(after.header.labels(0) == "walk");
  const bool is_walk = after.header.labels(after.nodes.main_clips(0)) == "walk";
  CHECK(after.nodes.label_fractions(0) == Approx(is_walk ? 2.0 / 3 : 1.0 / 3));
}

}  // namespace
}  // namespace motiondb::tests::state_map_test
