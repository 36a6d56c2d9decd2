// Formats on the command line: convert, formats, export --as, takes.
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/error.pb.h>
#include <motiondb/v1/plan.pb.h>

#include <array>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "client/cli/motion_file.h"
#include "tests/client/cli/ingest_answers.h"
#include "tests/client/fake_server.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/humanoid_bvh.h"

namespace motiondb::tests::convert_command_test {
namespace {

using Catch::Contains;
using Catch::StartsWith;

ProgramResult RunHere(const std::vector<std::string>& arguments) {
  return RunMotiondb("127.0.0.1:1", arguments);
}

TEST_CASE("motiondb convert: every written format, there and back", "[client][cli]") {
  const TemporaryFolder folder;
  const std::string bvh = folder.Write("a.bvh", HumanoidBvh(100, 60)).string();
  for (const std::string format : {"bvh", "trc", "c3d", "csv", "npz", "glb"}) {
    CAPTURE(format);
    const std::string there = (folder / ("there." + format)).string();
    const auto written = RunHere({"convert", bvh, there});
    CHECK(written.err.empty());
    REQUIRE(written.exit_code == 0);
    CHECK_THAT(written.out, StartsWith(there + ": ") && Contains("60 frames at 30 Hz") &&
                                Contains("read:  unit 0.01 m (deduced), y up"));
    const bool has_points = format == "trc" || format == "c3d" || format == "csv";
    CHECK((written.out.find("lost:  hierarchy and joint rotations") != std::string::npos) ==
          has_points);
    const auto inspected = RunHere({"inspect", there, "--json"});
    INFO(inspected.out);
    const auto answer = nlohmann::json::parse(inspected.out);
    CHECK(answer.at("frame_count") == 60);
    CHECK(answer.at("leg_length_m").get<double>() == Approx(0.82).epsilon(0.01));
  }
}

TEST_CASE("motiondb convert: the output is replaced only on request", "[client][cli]") {
  const TemporaryFolder folder;
  const std::string bvh = folder.Write("a.bvh", HumanoidBvh(100, 20)).string();
  const std::string out = folder.Write("b.trc", "mine").string();
  const auto refused = RunHere({"convert", bvh, out});
  CHECK(refused.exit_code == 1);
  CHECK_THAT(refused.err, Contains("--force"));
  CHECK(folder.Read("b.trc") == "mine");
  CHECK(RunHere({"convert", bvh, out, "--force"}).exit_code == 0);
  CHECK_THAT(folder.Read("b.trc"), StartsWith("PathFileType"));
  const auto json =
      RunHere({"convert", bvh, (folder / "c.data").string(), "--as", "csv", "--json"});
  CHECK(nlohmann::json::parse(json.out).at("frame_count") == 20);
  CHECK_THAT(folder.Read("c.data"), StartsWith("time_s,"));
}

TEST_CASE("motiondb convert: errors leave no file", "[client][cli]") {
  const TemporaryFolder folder;
  const std::string bvh = folder.Write("a.bvh", HumanoidBvh(100, 20)).string();
  const std::string bad = folder.Write("bad.bvh", "HIERARCHY\nnonsense\n").string();
  const auto unknown = RunHere({"convert", bvh, (folder / "a.fbx").string()});
  CHECK(unknown.exit_code == 2);
  CHECK_THAT(unknown.err, Contains("bvh|trc|c3d|csv|npz|glb"));
  const auto unreadable = RunHere({"convert", bad, (folder / "b.glb").string()});
  CHECK(unreadable.exit_code == 1);
  CHECK_THAT(unreadable.err, Contains("bad.bvh:2:"));
  CHECK(
      RunHere({"convert", (folder / "none.bvh").string(), (folder / "b.glb").string()}).exit_code ==
      1);
  CHECK(RunHere({"convert", bvh, (folder / "none/b.glb").string()}).exit_code == 1);
  CHECK(!std::filesystem::exists(folder / "a.fbx"));
  CHECK(!std::filesystem::exists(folder / "b.glb"));
}

TEST_CASE("motiondb formats: lists what is read and written", "[client][cli]") {
  const auto table = RunHere({"formats"});
  CHECK(table.exit_code == 0);
  CHECK_THAT(table.out, Contains(".fbx") && Contains(".gltf .glb .vrm") && Contains(".npz"));
  const auto json = nlohmann::json::parse(RunHere({"formats", "--json"}).out);
  REQUIRE(json.size() == 9);
  // The client's own table agrees with that of motiondb-import.
  std::set<std::string> extensions;
  for (const auto& format : json) {
    const std::string name = format.at("name");
    CHECK(format.at("is_written") == (name != "amc" && name != "fbx" && name != "dae"));
    std::istringstream words(format.at("extensions").get<std::string>());
    for (std::string word; words >> word;) {
      extensions.insert(word);
      CHECK(client::IsMotionFile("walk" + word));
      const auto written = client::WrittenFormat(word);
      if (written.ok()) CHECK(client::NameOfFormat(*written) == name);
    }
  }
  std::istringstream known(client::MotionExtensions());
  for (std::string word; known >> word;) {
    if (word.ends_with(',')) word.pop_back();
    CHECK(extensions.contains(word));
  }
}

TEST_CASE("motiondb export --as: requests the format and prints the notes", "[client][cli]") {
  FakeServer server;
  const TemporaryFolder folder;
  v1::ExportClipResponse header, block;
  header.mutable_header()->mutable_clip()->set_file_name("walk.bvh");
  header.mutable_header()->set_file_name("walk.glb");
  header.mutable_header()->add_notes("joint angles fit within 1 mm");
  block.set_file_block("glTF");
  server.Answer("ExportClip", header, block);
  const auto result = RunMotiondb(server.address(), {"export", "walks", "walk", "--as", "glb",
                                                     "--out", folder.path().string()});
  CHECK(result.err.empty());
  CHECK_THAT(result.out, Contains("walk.glb") && Contains("note:  joint angles fit within 1 mm"));
  CHECK(folder.Read("walk.glb") == "glTF");
  const auto requests = server.Requests<v1::ExportClipRequest>("ExportClip");
  REQUIRE(requests.size() == 1);
  CHECK(requests[0].format() == v1::FILE_FORMAT_GLTF);
  CHECK(RunMotiondb(server.address(), {"export", "walks", "walk", "--as", "fbx"}).exit_code == 2);
}

TEST_CASE("motiondb ingest: all takes of a file, or one", "[client][cli]") {
  FakeServer server;
  ServeDatabase(server);
  const TemporaryFolder folder;
  const std::string file = folder.Write("two.glb", "glTF").string();
  v1::ErrorInfo info;
  info.set_reason("TAKE_REQUIRED");
  (*info.mutable_metadata())["takes"] = R"(["walk"])";  // the list may be cut
  (*info.mutable_metadata())["take_count"] = "2";
  v1::Status details;
  details.set_code(3);
  details.add_details()->PackFrom(info);
  details.mutable_details(0)->set_type_url("type.googleapis.com/google.rpc.ErrorInfo");
  server.Fail("IngestClip", 3, "two.glb: has 2 takes", details.SerializeAsString());
  server.Answer("IngestClip", StoredClip("two-walk", "operations/6"));
  server.Answer("IngestClip", StoredClip("two-run", "operations/7"));
  const auto result = RunMotiondb(server.address(), {"ingest", "walks", file, "--verbose"});
  CHECK(result.err.empty());
  CHECK(result.exit_code == 0);
  auto headers = IngestHeaders(server);
  REQUIRE(headers.size() == 3);
  CHECK(headers[0].conventions().take().empty());
  CHECK(headers[1].conventions().take() == "walk");
  CHECK(headers[2].conventions().take() == "2");

  CHECK(RunMotiondb(server.address(), {"ingest", "walks", file, "--take", "run", "--label", "jog"})
            .exit_code == 0);
  headers = IngestHeaders(server);
  REQUIRE(headers.size() == 4);
  CHECK(headers[3].conventions().take() == "run");
  CHECK(headers[3].label() == "jog");
}

TEST_CASE("motiondb plan --out: the extension selects the format", "[client][cli]") {
  const std::vector<std::pair<std::string, v1::FileFormat>> formats = {
      {"p.bvh", v1::FILE_FORMAT_BVH}, {"p.GLB", v1::FILE_FORMAT_GLTF},
      {"p.c3d", v1::FILE_FORMAT_C3D}, {"p.csv", v1::FILE_FORMAT_CSV},
      {"p.npz", v1::FILE_FORMAT_NPZ}, {"p.trc", v1::FILE_FORMAT_TRC}};
  for (const auto& [name, format] : formats) {
    CAPTURE(name);
    FakeServer server;
    const TemporaryFolder folder;
    v1::PlanResponse response;
    response.set_outcome(v1::PLAN_OUTCOME_EXACT);
    response.mutable_motion()->mutable_file()->set_data("data");
    server.Answer("Plan", response);
    CHECK(RunMotiondb(server.address(),
                      {"plan", "walks", "--goal", "1,0,0", "--out", (folder / name).string()})
              .exit_code == 0);
    const auto requests = server.Requests<v1::PlanRequest>("Plan");
    REQUIRE(requests.size() == 1);
    CHECK(requests[0].include_files());
    CHECK(requests[0].file_format() == format);
    CHECK(folder.Read(name) == "data");
  }
}

}  // namespace
}  // namespace motiondb::tests::convert_command_test
