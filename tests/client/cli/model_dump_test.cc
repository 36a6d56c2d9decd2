#include "client/cli/model_dump.h"

#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/model.pb.h>

#include <catch2/catch.hpp>
#include <cstring>

#include "tests/client/fake_server.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::model_dump_test {
namespace {

using client::NpyHeader;
using client::NpyType;

// REQUIRES: the machine is little-endian.
template <typename Number>
std::string Packed(std::initializer_list<Number> numbers) {
  std::string bytes;
  for (const Number number : numbers) {
    char raw[sizeof(Number)];
    std::memcpy(raw, &number, sizeof(Number));
    bytes.append(raw, sizeof(Number));
  }
  return bytes;
}

std::string Floats(std::initializer_list<float> numbers) { return Packed(numbers); }
std::string Ints(std::initializer_list<int32_t> numbers) { return Packed(numbers); }

v1::ListNodesResponse Nodes(const std::vector<int>& parents) {
  v1::ListNodesResponse page;
  for (const int parent : parents) {
    auto* node = page.add_nodes();
    node->set_node_id(page.nodes_size() - 1);
    if (parent >= 0) node->set_parent_id(parent);
    node->set_mean(Floats({static_cast<float>(page.nodes_size()), 0.5f}));
    node->set_variance(Floats({1, 2}));
  }
  return page;
}

v1::ListTransitionsResponse Transitions(int from, int to, int count) {
  v1::ListTransitionsResponse page;
  auto* transition = page.add_transitions();
  transition->set_from_node_id(from);
  transition->set_to_node_id(to);
  transition->set_count(count);
  return page;
}

// A model with five frames of two dimensions in two clips, and layers of 1, 2 and 3 nodes.
v1::Model SmallModel() {
  v1::Model model;
  model.set_name("databases/walks/models/3");
  model.set_version(3);
  model.set_frame_count(5);
  model.set_dimension_count(2);
  for (const int nodes : {1, 2, 3}) model.add_nodes_per_layer(nodes);
  model.add_clips("databases/walks/clips/a");
  model.add_clips("databases/walks/clips/b");
  model.add_first_frames(0);
  model.add_first_frames(2);
  return model;
}

void ServeSmallModel(FakeServer& server, const v1::Model& model) {
  v1::GetDatabaseResponse database;
  database.mutable_database()->set_name("databases/walks");
  database.mutable_database()->set_frame_rate_hz(60);
  database.mutable_database()->add_marker_names("the \"root\"");
  server.Answer("GetDatabase", database);
  v1::GetModelResponse response;
  *response.mutable_model() = model;
  server.Answer("GetModel", response);
  v1::ReadStatesResponse first, second;
  first.set_frame_count(3);
  first.set_states(Floats({0, 1, 2, 3, 4, 5}));
  for (const int node : {0, 0, 1}) first.add_bottom_node_ids(node);
  second.set_first_frame(3);
  second.set_frame_count(2);
  second.set_states(Floats({6, 7, 8, 9}));
  for (const int node : {2, 1}) second.add_bottom_node_ids(node);
  server.Answer("ReadStates", first, second);
  server.Answer("ListNodes", Nodes({0, 1, 1}));  // layer 3
  server.Answer("ListNodes", Nodes({0, 0}));     // layer 2
  server.Answer("ListNodes", Nodes({-1}));       // layer 1
  server.Answer("ListTransitions", Transitions(0, 1, 3));
  server.Answer("ListTransitions", Transitions(1, 1, 4));
  server.Answer("ListTransitions", Transitions(0, 0, 5));
}

TEST_CASE("Dump: shapes and values of all files", "[client][cli]") {
  FakeServer server;
  ServeSmallModel(server, SmallModel());
  const TemporaryFolder folder;
  const auto out = folder / "dump";
  const auto result = RunMotiondb(server.address(), {"dump", "walks", out.string()});
  CHECK(result.err == "");
  REQUIRE(result.exit_code == 0);
  CHECK_THAT(result.out, Catch::StartsWith("model 3: 5 frames, 2 dimensions, 3 layers"));

  CHECK(ReadFile(out / "states.npy") ==
        NpyHeader(NpyType::kFloat32, {5, 2}) + Floats({0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
  CHECK(ReadFile(out / "clip_of_frame.npy") ==
        NpyHeader(NpyType::kInt32, {5}) + Ints({0, 0, 1, 1, 1}));
  const auto layers = out / "layers";
  CHECK(ReadFile(layers / "03/node_of_frame.npy") ==
        NpyHeader(NpyType::kInt32, {5}) + Ints({0, 0, 1, 2, 1}));
  CHECK(ReadFile(layers / "02/node_of_frame.npy") ==
        NpyHeader(NpyType::kInt32, {5}) + Ints({0, 0, 1, 1, 1}));
  CHECK(ReadFile(layers / "01/node_of_frame.npy") ==
        NpyHeader(NpyType::kInt32, {5}) + Ints({0, 0, 0, 0, 0}));
  CHECK(ReadFile(layers / "03/parent.npy") == NpyHeader(NpyType::kInt32, {3}) + Ints({0, 1, 1}));
  CHECK(ReadFile(layers / "01/parent.npy") == NpyHeader(NpyType::kInt32, {1}) + Ints({-1}));
  CHECK(ReadFile(layers / "02/mean.npy") ==
        NpyHeader(NpyType::kFloat32, {2, 2}) + Floats({1, 0.5f, 2, 0.5f}));
  CHECK(ReadFile(layers / "02/variance.npy") ==
        NpyHeader(NpyType::kFloat32, {2, 2}) + Floats({1, 2, 1, 2}));
  CHECK(ReadFile(layers / "03/transitions.npy") ==
        NpyHeader(NpyType::kInt32, {1, 3}) + Ints({0, 1, 3}));
  const std::string json = ReadFile(out / "model.json");
  CHECK_THAT(json, Catch::Contains("\"dimension_count\": 2") && Catch::Contains("states.npy") &&
                       Catch::Contains(R"("marker_names": ["the \"root\""])"));
  // All calls use the version that is current at the start, layer by layer from the bottom.
  const auto requests = server.Requests<v1::ListNodesRequest>("ListNodes");
  REQUIRE(requests.size() == 3);
  CHECK(requests[0].parent() == "databases/walks/models/3");
  CHECK(requests[0].layer() == 3);
  CHECK(requests[2].layer() == 1);
}

TEST_CASE("Dump: NumPy reads the files", "[client][cli]") {
  if (RunProgram({"/usr/bin/python3", "-c", "import numpy"}).exit_code != 0) {
    WARN("skipped: /usr/bin/python3 has no numpy (Debian: python3-numpy)");
    return;
  }
  FakeServer server;
  ServeSmallModel(server, SmallModel());
  const TemporaryFolder folder;
  REQUIRE(RunMotiondb(server.address(), {"dump", "walks", folder.path().string()}).exit_code == 0);
  const auto result = RunProgram({"/usr/bin/python3", "-c",
                                  "import json, sys, numpy as np\n"
                                  "d = sys.argv[1] + '/'\n"
                                  "s = np.load(d + 'states.npy')\n"
                                  "assert s.dtype == np.float32 and s.shape == (5, 2)\n"
                                  "assert (s == np.arange(10).reshape(5, 2)).all()\n"
                                  "n = np.load(d + 'layers/02/node_of_frame.npy')\n"
                                  "assert n.dtype == np.int32 and n.tolist() == [0, 0, 1, 1, 1]\n"
                                  "t = np.load(d + 'layers/03/transitions.npy')\n"
                                  "assert t.tolist() == [[0, 1, 3]]\n"
                                  "m = json.load(open(d + 'model.json'))\n"
                                  "assert m['model']['version'] == 3\n"
                                  "assert m['marker_names'] == ['the \"root\"']\n",
                                  folder.path().string()});
  CHECK(result.err == "");
  CHECK(result.exit_code == 0);
}

TEST_CASE("Dump: a folder that is not empty is refused; --force replaces only a dump",
          "[client][cli]") {
  FakeServer server;
  ServeSmallModel(server, SmallModel());
  const TemporaryFolder folder;
  folder.Write("mine.txt", "mine");
  folder.Write("layers/17/mean.npy", "an earlier dump");
  const auto refused = RunMotiondb(server.address(), {"dump", "walks", folder.path().string()});
  CHECK(refused.exit_code == 1);
  CHECK_THAT(refused.err, Catch::StartsWith("motiondb: ") && Catch::Contains("--force"));
  CHECK(!std::filesystem::exists(folder / "states.npy"));
  const auto forced =
      RunMotiondb(server.address(), {"dump", "walks", folder.path().string(), "--force"});
  CHECK(forced.exit_code == 0);
  CHECK(ReadFile(folder / "mine.txt") == "mine");
  CHECK(!std::filesystem::exists(folder / "layers/17"));
  CHECK(std::filesystem::exists(folder / "layers/03/mean.npy"));
}

TEST_CASE("Dump: states that do not match the model are DATA_LOSS, without model.json",
          "[client][cli]") {
  FakeServer server;
  v1::Model model = SmallModel();
  model.set_frame_count(6);
  ServeSmallModel(server, model);
  const TemporaryFolder folder;
  const auto result = RunMotiondb(server.address(), {"dump", "walks", folder.path().string()});
  CHECK(result.exit_code == 1);
  CHECK_THAT(result.err, Catch::Contains("expected nodes of 6 frames"));
  CHECK(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace motiondb::tests::model_dump_test
