// Scenes made to break readers: each gives an error or a valid motion.
//
// assimp 5.2.5 itself crashes, hangs or uses all memory on some inputs, which are not here; in
// motiondb-import they end a process with limits:
// - trees of nodes of a depth of about 10,000 and more, and FBX text nested as deep (stack);
// - cycles of FBX models, and of Collada nodes through <instance_node> (stack);
// - glTF nodes in which each of many levels refers twice to the next (memory);
// - chunk lengths of GLB and counts of Collada arrays far beyond the file (one huge allocation);
// - accessors of Collada beyond their arrays (an assertion of assimp);
// - FBX and Collada rotations of very many turns between two keys (memory, time).
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "import/scene/scene_reader.h"
#include "tests/core/format/reading.h"
#include "tests/import/scene/scene_files.h"

namespace motiondb::tests::hostile_scenes_test {
namespace {

using core::FileFormat;

// Reads the scene, and checks the motion or the error.
absl::StatusOr<core::MotionFile> ReadHostile(FileFormat format, std::string_view bytes) {
  auto file = importer::ReadScene(format, {.name = "hostile", .bytes = bytes}, {});
  if (file.ok()) {
    CHECK(Joints(file).angles.rows() > 0);
    CHECK(Joints(file).angles.allFinite());
    CHECK(Joints(file).skeleton->joint_count() <= core::kMaxFileJoints);
  } else {
    CHECK(ErrorMessageOf(file).starts_with("hostile:"));
  }
  return file;
}

void CheckRejected(const GltfFile& file) {
  CHECK_FALSE(ReadHostile(FileFormat::kGltf, file.Text()).ok());
}

FbxFile SmallFbx() {
  FbxFile file;
  file.models = {{"Hips", -1, {{"Lcl Translation", {0, 100, 0}}}},
                 {"Head", 0, {{"Lcl Translation", {0, 50, 0}}, {"PreRotation", {0, 0, 90}}}}};
  file.curves = {{0, "Lcl Rotation", {{{{0, 0}, {0.1, 30}}, {{0, 0}, {0.1, 20}}, {}}}}};
  return file;
}

}  // namespace

TEST_CASE("Hostile scenes: glTF nodes", "[import][scene]") {
  GltfFile cycle = NoddingFigure(3);
  cycle.json["nodes"][1]["children"] = {0};
  CheckRejected(cycle);

  GltfFile self = NoddingFigure(3);
  self.json["nodes"][0]["children"] = {0};
  CheckRejected(self);

  GltfFile missing = NoddingFigure(3);
  missing.json["nodes"][0]["children"] = {1, 77};
  CheckRejected(missing);

  // assimp makes two nodes of one with two parents.
  GltfFile two_parents = NoddingFigure(3);
  two_parents.json["nodes"][0]["children"] = {1, 2};
  two_parents.json["nodes"].push_back({{"name", "Neck"}, {"children", {1}}});
  CHECK(ReadHostile(FileFormat::kGltf, two_parents.Text()).ok());

  GltfFile deep = NoddingFigure(3);
  for (int n = 1; n < 2500; ++n) {
    deep.json["nodes"][static_cast<std::size_t>(n)] = {{"children", {n + 1}}};
  }
  deep.json["nodes"].push_back({{"name", "Last"}});
  CheckRejected(deep);

  GltfFile wide = NoddingFigure(3);
  for (int n = 2; n < 5000; ++n) {
    wide.json["nodes"].push_back({{"name", "Hips"}});
    wide.json["nodes"][0]["children"].push_back(n);
  }
  CheckRejected(wide);
}

TEST_CASE("Hostile scenes: glTF numbers", "[import][scene]") {
  constexpr float kHuge = 1e38F;
  GltfFile huge = NoddingFigure(3);
  huge.json["nodes"][0]["scale"] = {kHuge, kHuge, kHuge};
  huge.json["nodes"][1]["translation"] = {kHuge, kHuge, kHuge};
  CheckRejected(huge);

  GltfFile flat = NoddingFigure(3);
  flat.json["nodes"][0]["scale"] = {0, 0, 0};
  flat.json["nodes"][1]["scale"] = {0, 1, 1};
  CHECK(ReadHostile(FileFormat::kGltf, flat.Text()).ok());

  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const float odd : {nan, std::numeric_limits<float>::infinity(), kHuge, -kHuge}) {
    for (std::size_t place = 0; place < 6; ++place) {
      std::vector<float> times = {0, 0.1F};
      std::vector<float> moves = {0, 0, 0, 1, 1, 1};
      moves[place] = odd;
      if (place < 2) times[place] = odd;
      GltfFile file = NoddingFigure(3);
      file.json["animations"].clear();
      file.AddChannel(file.AddTake("A"), 0, "translation", times, moves);
      CheckRejected(file);
    }
  }
}

TEST_CASE("Hostile scenes: glTF accessors and buffers", "[import][scene]") {
  struct Change {
    const char* array;
    const char* member;
    nlohmann::json value;
  };
  const std::vector<Change> changes = {{"accessors", "count", 4'000'000'000U},
                                       {"accessors", "count", 1000},
                                       {"accessors", "count", -1},
                                       {"accessors", "byteOffset", 4'000'000'000U},
                                       {"accessors", "bufferView", 99},
                                       {"accessors", "type", "MAT4"},
                                       {"accessors", "type", 5},
                                       {"accessors", "componentType", 0},
                                       {"accessors", "componentType", 5124},
                                       {"accessors", "componentType", 5120},
                                       {"accessors", "componentType", 5125},
                                       {"accessors", "componentType", "5126"},
                                       {"accessors", "componentType", -1},
                                       {"accessors", "count", 2},
                                       {"accessors", "count", 4},
                                       {"accessors", "sparse", {{"count", 1}}},
                                       {"accessors", "bufferView", "x"},
                                       {"bufferViews", "buffer", 99},
                                       {"bufferViews", "byteOffset", 1'000'000},
                                       {"bufferViews", "byteLength", 1'000'000'000'000},
                                       {"bufferViews", "byteStride", 1'000'000},
                                       {"buffers", "byteLength", 1'000'000'000'000},
                                       {"buffers", "uri", "data:,"},
                                       {"buffers", "uri", "../../etc/passwd"},
                                       {"animations", "samplers", nullptr},
                                       {"animations", "channels", 7}};
  for (const Change& change : changes) {
    for (std::size_t i = 0; i < 2; ++i) {
      GltfFile file = NoddingFigure(3);
      if (i >= file.json[change.array].size()) continue;
      file.json[change.array][i][change.member] = change.value;
      INFO(change.array << "[" << i << "]." << change.member << " = " << change.value.dump());
      CheckRejected(file);
    }
  }
  for (const char* member : {"sampler", "target"}) {
    GltfFile file = NoddingFigure(3);
    file.json["animations"][0]["channels"][0][member] = 99;
    CheckRejected(file);
  }
  GltfFile many = NoddingFigure(3);
  for (int take = 0; take < 1000; ++take) {
    many.json["animations"].push_back(many.json["animations"][0]);
  }
  const auto takes = ReadHostile(FileFormat::kGltf, many.Text());
  CHECK_THAT(ErrorMessageOf(takes),
             Catch::Contains("Nod_9, Nod_10") && Catch::EndsWith("more): name one"));
}

TEST_CASE("Hostile scenes: text that is no scene", "[import][scene]") {
  const std::vector<std::string> texts = {"",
                                          " ",
                                          "{",
                                          "null",
                                          std::string(1000, '\0'),
                                          std::string(100'000, '['),
                                          R"({"asset":{"version":"2.0"}})",
                                          "<COLLADA/>",
                                          "PK\x03\x04",
                                          "\xFF\xFE<",
                                          "glTF",
                                          "Kaydara FBX Binary  ",
                                          "; FBX 7.4.0 project file\nObjects:  {\n"};
  for (const std::string& text : texts) {
    INFO(text.substr(0, 40));
    for (const FileFormat format : {FileFormat::kFbx, FileFormat::kGltf, FileFormat::kCollada}) {
      CHECK_FALSE(ReadHostile(format, text).ok());
    }
  }
}

TEST_CASE("Hostile scenes: truncated files", "[import][scene]") {
  const std::string glb = NoddingFigure(10).Binary();
  for (std::size_t size = 0; size < glb.size(); size += 13) {
    CHECK_FALSE(ReadHostile(FileFormat::kGltf, std::string_view(glb).substr(0, size)).ok());
  }
  const std::string gltf = NoddingFigure(3).Text();
  for (std::size_t size = 0; size < gltf.size(); size += 29) {
    CHECK_FALSE(ReadHostile(FileFormat::kGltf, std::string_view(gltf).substr(0, size)).ok());
  }
  const std::string collada = ColladaFile().Text();
  for (std::size_t size = 0; size < collada.size(); size += 17) {
    CHECK_FALSE(ReadHostile(FileFormat::kCollada, std::string_view(collada).substr(0, size)).ok());
  }
  const std::string lines = Replaced(collada, "<library_animations>", "\n<library_animations>\n");
  CHECK_THAT(ErrorMessageOf(importer::ReadScene(
                 FileFormat::kCollada,
                 {.name = "walk.dae", .bytes = std::string_view(lines).substr(0, 600)}, {})),
             Catch::StartsWith("walk.dae:") && Catch::Contains("expected well-formed XML") &&
                 Catch::EndsWith("It ends at byte 600"));
  // FBX without its last connections is a complete file.
  const std::string fbx = SmallFbx().Text();
  CHECK(ReadHostile(FileFormat::kFbx, fbx).ok());
  for (std::size_t size = 0; size < fbx.size(); size += 23) {
    ReadHostile(FileFormat::kFbx, std::string_view(fbx).substr(0, size)).IgnoreError();
  }
}

TEST_CASE("Hostile scenes: FBX", "[import][scene]") {
  const std::string text = SmallFbx().Text();
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
           {"KeyTime: *2", "KeyTime: *7"},
           {"KeyValueFloat: *2", "KeyValueFloat: *1"},
           {"KeyTime", "KeyTimf"},
           {"a: 0,30", "a: 0,nan"},
           {"a: 0,30", "a: 0,1e39"},
           {"\"Lcl Translation\"", "\"Lcl Translatiom\""},
           {"\"UnitScaleFactor\", \"double\", \"Number\", \"\",1",
            "\"UnitScaleFactor\", \"double\", \"Number\", \"\",0"},
           {"\"UnitScaleFactor\", \"double\", \"Number\", \"\",1",
            "\"UnitScaleFactor\", \"double\", \"Number\", \"\",-1"},
           {"\"TimeMode\", \"int\", \"Integer\", \"\",6",
            "\"TimeMode\", \"int\", \"Integer\", \"\",14"},
           {"\"TimeMode\", \"int\", \"Integer\", \"\",6",
            "\"TimeMode\", \"int\", \"Integer\", \"\",99"},
           {"\"UpAxis\", \"int\", \"Integer\", \"\",1", "\"UpAxis\", \"int\", \"Integer\", \"\",7"},
           {"Model::Head", "Model::Hips"},
           {"Model::Head", "Model::Hips_$AssimpFbx$_Rotation"},
           {"Model::Head", "Model::Head_$AssimpFbx$_GeometricScalingInverse"},
           {"Model::Hips", "Model::"}}) {
    INFO(from << " -> " << to);
    ReadHostile(FileFormat::kFbx, Replaced(text, from, to)).IgnoreError();
  }
  FbxFile unsorted = SmallFbx();
  unsorted.curves[0].keys[0] = {{0.1, 0}, {0, 30}};
  unsorted.curves[0].keys[1] = {};
  ReadHostile(FileFormat::kFbx, unsorted.Text()).IgnoreError();
  // A take that begins before 0 is whole: assimp moves its begin to 0.
  FbxFile early = SmallFbx();
  early.curves[0].keys[0] = {{-1, 0}, {0, 30}};
  early.curves[0].keys[1] = {};
  CHECK(Joints(ReadHostile(FileFormat::kFbx, early.Text())).angles.rows() == 31);
}

TEST_CASE("Hostile scenes: Collada", "[import][scene]") {
  for (const char* times : {"-1 0 1", "0 0 0", "0 1e30 2e30"}) {
    ColladaFile file;
    file.times = times;
    INFO(times);
    CHECK_FALSE(ReadHostile(FileFormat::kCollada, file.Text()).ok());
  }
  for (const char* times : {"0 nan 0.2", "0.2 0.1 0"}) {  // assimp skips keys
    ColladaFile file;
    file.times = times;
    ReadHostile(FileFormat::kCollada, file.Text()).IgnoreError();
  }
  const std::string text = ColladaFile().Text();
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
           {"source=\"#t\"", "source=\"#z\""},
           {"semantic=\"OUTPUT\"", "semantic=\"OTHER\""},
           {"Hips/turn.ANGLE", "Hips"},
           {"Hips/turn.ANGLE", "Hips/other.X"},
           {"Hips/turn.ANGLE", "Nobody/turn.ANGLE"}}) {
    INFO(from << " -> " << to);
    CHECK_FALSE(ReadHostile(FileFormat::kCollada, Replaced(text, from, to)).ok());
  }
  ColladaFile twice;
  twice.libraries = "<library_nodes><node id=\"L\"/></library_nodes>";
  twice.nodes = Replaced(twice.nodes, "<node id=\"Head\"",
                         "<instance_node url=\"#L\"/><instance_node url=\"#L\"/><node id=\"Head\"");
  CHECK(ReadHostile(FileFormat::kCollada, twice.Text()).ok());
}

}  // namespace motiondb::tests::hostile_scenes_test
