#include "import/scene/scene_reader.h"

#include <Eigen/Geometry>
#include <assimp/Importer.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"
#include "tests/import/imported.h"
#include "tests/import/scene/scene_files.h"
#include "tests/import/scene/scene_player.h"

namespace motiondb::tests::scene_reader_test {
namespace {

using Catch::Contains;
using core::FileFormat;
using core::Provenance;
using core::UpAxis;
using Eigen::Vector3d;

absl::StatusOr<core::MotionFile> ReadGltf(const GltfFile& file, std::string_view take = "") {
  core::ReadOptions options;
  options.take = take;
  return ReadSceneBytes(FileFormat::kGltf, file.Text(), options);
}

// A tree of nodes with any translations, rotations and scales, of which some move.
GltfFile RandomScene(std::mt19937& random) {
  std::uniform_real_distribution<float> number(-1, 1);
  const auto vector = [&](float length, float middle) {
    return std::vector<float>{middle + length * number(random), middle + length * number(random),
                              middle + length * number(random)};
  };
  const auto rotation = [&] {
    const Eigen::Quaternionf q =
        Eigen::Quaternionf(number(random), number(random), number(random), number(random))
            .normalized();
    return std::vector<float>{q.x(), q.y(), q.z(), q.w()};
  };
  GltfFile file;
  const int take = file.AddTake("Random");
  for (int n = 0; n < 12; ++n) {
    nlohmann::json node = {
        {"name", "n" + std::to_string(n)}, {"translation", vector(1, 0)}, {"rotation", rotation()}};
    if (random() % 2 == 0) node["scale"] = vector(0.5F, 1);
    file.json["nodes"].push_back(node);
    if (n == 0) continue;
    const std::size_t parent = random() % static_cast<unsigned>(n);
    file.json["nodes"][parent]["children"].push_back(n);
  }
  for (int n = 0; n < 12; n += 2) {
    std::vector<float> times;
    std::vector<float> turns;
    std::vector<float> moves;
    std::vector<float> scales;
    for (int key = 0; key < 9; ++key) {
      times.push_back(0.1F + static_cast<float>(key) / 25);
      for (const float x : rotation()) turns.push_back(x);
      for (const float x : vector(1, 0)) moves.push_back(x);
      for (const float x : vector(0.3F, 1)) scales.push_back(x);
    }
    file.AddChannel(take, n, "rotation", times, turns);
    if (n % 4 == 0) file.AddChannel(take, n, "translation", times, moves);
    if (n % 6 == 0) file.AddChannel(take, n, "scale", times, scales);
  }
  return file;
}

}  // namespace

TEST_CASE("Scene: joint positions are those of the tree of nodes, with any scales",
          "[import][scene]") {
  std::mt19937 random(7);
  for (int trial = 0; trial < 20; ++trial) {
    const std::string text = RandomScene(random).Text();
    const auto file =
        importer::ReadScene(FileFormat::kGltf, {.name = "random.gltf", .bytes = text}, {});
    const core::JointMotion& motion = Joints(file);
    CHECK(motion.frame_rate_hz == 25);
    REQUIRE(motion.angles.rows() == 9);
    REQUIRE(motion.skeleton->joint_count() == 12);

    Assimp::Importer player_importer;
    const aiScene* const scene =
        player_importer.ReadFileFromMemory(text.data(), text.size(), 0, "gltf");
    REQUIRE(scene != nullptr);
    const ScenePlayer player(*scene, 0);
    for (Eigen::Index frame = 0; frame < motion.angles.rows(); ++frame) {
      const auto expected =
          player.At(player.FirstTick() + static_cast<double>(frame) * player.TicksPerSecond() / 25);
      for (const auto& [name, position] : expected) {
        const Vector3d in_world(position.x(), -position.z(), position.y());
        INFO("trial " << trial << ", frame " << frame << ", node " << name);
        CHECK(Near(PositionOf(motion, name, frame), in_world, 1e-4 * 5));
      }
    }
  }
}

TEST_CASE("Scene: a glTF figure is in metres, y up", "[import][scene]") {
  const GltfFile figure = NoddingFigure(10);
  const auto file = ReadGltf(figure);
  const core::JointMotion& motion = Joints(file);
  CHECK(file->report.metres_per_unit == 1);
  CHECK(file->report.unit_provenance == Provenance::kStated);
  CHECK(file->report.up_axis == UpAxis::kY);
  CHECK(file->report.up_provenance == Provenance::kStated);
  CHECK(file->report.notes == std::vector<std::string>{"frame rate 30 Hz deduced from the keys"});
  CHECK(motion.frame_rate_hz == 30);
  CHECK(motion.angles.rows() == 10);
  CHECK(motion.skeleton->joints()[0].dofs.size() == 3);
  CHECK(motion.skeleton->joints()[1].dofs.empty());
  // Turning about x moves the head from y to z of the file: from z to -y of the world.
  for (const int frame : {0, 3, 9}) {
    const double turn = 0.1 * frame;
    CHECK(Near(PositionOf(motion, "Hips", frame), {0, 0, 1}));
    CHECK(Near(PositionOf(motion, "Head", frame),
               {0, -0.5 * std::sin(turn), 1 + 0.5 * std::cos(turn)}));
  }
  const std::string binary = figure.Binary();
  const auto glb = importer::ReadScene(FileFormat::kGltf, {.name = "x", .bytes = binary}, {});
  CHECK(Joints(glb).angles == motion.angles);
}

TEST_CASE("Scene: unit, axis and rate that are given replace those of the file",
          "[import][scene]") {
  core::ReadOptions options;
  options.metres_per_unit = 0.01;
  options.up_axis = UpAxis::kZ;
  options.frame_rate_hz = 60;
  const std::string text = NoddingFigure(10).Text();
  const auto file = importer::ReadScene(FileFormat::kGltf, {.name = "x", .bytes = text}, options);
  CHECK(file->report.unit_provenance == Provenance::kGiven);
  CHECK(file->report.up_provenance == Provenance::kGiven);
  CHECK(Joints(file).frame_rate_hz == 60);
  CHECK(Joints(file).angles.rows() == 10);
  CHECK(Near(PositionOf(Joints(file), "Head", 0), {0, 0.015, 0}));
}

TEST_CASE("Scene: a file with several takes needs a choice", "[import][scene]") {
  GltfFile file = NoddingFigure(10);
  file.json["animations"][0]["name"] = "Walk";
  file.json["animations"].push_back(file.json["animations"][0]);
  file.json["animations"].push_back(file.json["animations"][0]);
  file.json["animations"][1]["name"] = "";
  file.json["animations"][2]["name"] = "Walk";
  const auto unclear = ReadGltf(file);
  CHECK(ErrorMessageOf(unclear) == "walk.glb: has 3 takes (Walk, take 2, Walk_2): name one");
  CHECK(unclear.status().GetPayload(core::kReasonUrl) == absl::Cord("TAKE_REQUIRED"));
  CHECK(unclear.status().GetPayload("motiondb.metadata/takes") ==
        absl::Cord(R"(["Walk","take 2","Walk_2"])"));
  CHECK(ReadGltf(file, "Walk_2").ok());
  CHECK(ReadGltf(file, "2").ok());
  for (const std::string_view wrong : {"0", "4", "walk", "-1", "99999999999999999999"}) {
    CHECK_THAT(ErrorMessageOf(ReadGltf(file, wrong)), Contains("has no take '"));
  }
}

TEST_CASE("Scene: a take in which nothing moves does not count", "[import][scene]") {
  GltfFile file = NoddingFigure(10);
  const int still = file.AddTake("Still");
  file.AddChannel(still, 0, "translation", {0, 1}, {0, 1, 0, 0, 1, 0});
  CHECK(Joints(ReadGltf(file)).angles.rows() == 10);
  file.json["animations"].erase(0);
  const auto only = ReadGltf(file);
  CHECK(Joints(only).angles.rows() == 31);
  CHECK_THAT(only->report.notes.back(), Contains("keys are sparse (every 1 s): sampled at 30 Hz"));
}

TEST_CASE("Scene: frames come from the times of the keys", "[import][scene]") {
  const auto read = [](const std::vector<float>& times) {
    GltfFile file;
    file.json["nodes"] = {{{"name", "Hips"}}};
    std::vector<float> moves;
    for (const float time : times) moves.insert(moves.end(), {time, 0, 0});
    file.AddChannel(file.AddTake("A"), 0, "translation", times, moves);
    return ReadGltf(file);
  };
  // Times rounded to milliseconds.
  const auto rounded = read({0, 0.033F, 0.067F, 0.1F, 0.133F, 0.167F, 0.2F});
  CHECK(Joints(rounded).frame_rate_hz == 30);
  CHECK(Joints(rounded).angles.rows() == 7);
  // Irregular keys on a grid of 1/60 s: interpolated.
  const auto irregular = read({1, 1 + 1.0F / 60, 1 + 4.0F / 60, 1 + 5.0F / 60, 1 + 9.0F / 60});
  REQUIRE(Joints(irregular).frame_rate_hz == 60);
  REQUIRE(Joints(irregular).angles.rows() == 10);
  CHECK(PositionOf(Joints(irregular), "Hips", 3).x() == Approx(1 + 3.0 / 60));
  CHECK_THAT(irregular->report.notes.back(), Contains("irregular"));

  CHECK(ErrorMessageOf(read({1})) ==
        "walk.glb: take 'A': no joint has more than one key: it does not move");
  CHECK(ErrorMessageOf(read({1, 1})) ==
        "walk.glb: take 'A': lasts 0 s, from its first to its last key");
  CHECK_THAT(ErrorMessageOf(read({0, 2e6F})), Contains("more than 4000000 joint poses"));
}

TEST_CASE("Scene: keys that cannot be used are rejected with node and number", "[import][scene]") {
  const auto read = [](const std::vector<float>& times, const std::vector<float>& turns) {
    GltfFile file = NoddingFigure(3);
    file.json["animations"].clear();
    file.AddChannel(file.AddTake("A"), 1, "rotation", times, turns);
    return ErrorMessageOf(ReadGltf(file));
  };
  const std::vector<float> turns = {0, 0, 0, 1, 0.6F, 0, 0, 0.8F};
  CHECK(read({-1, 0}, turns) ==
        "walk.glb: take 'A', node 'Head', rotation key 1: expected a time from 0, found -1000");
  CHECK(read({1, 0.5F}, turns) ==
        "walk.glb: take 'A', node 'Head', rotation key 2: expected a time from 1000 (ticks), found "
        "500");
  CHECK_THAT(read({0, NAN}, turns), Contains("rotation key 2: expected a time from 0, found nan"));
  CHECK_THAT(read({0, 1}, {0, 0, 0, 1, 0, 0, 0, 0}), Contains("key 2: expected a unit quaternion"));
  CHECK_THAT(read({0, 1}, {0, 0, 0, NAN, 0, 0, 0, 1}), Contains("key 1: expected a unit"));
}

TEST_CASE("Scene: joints are bones, animated nodes and what lies between", "[import][scene]") {
  GltfFile file = NoddingFigure(5);
  const int points = file.AddFloats({0, 0, 0, 1, 0, 0, 0, 1, 0}, 3);
  file.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", points}}}}}}}};
  file.json["cameras"] = {
      {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}}};
  file.json["nodes"] = {{{"name", "Scene"}, {"children", {1, 2}}, {"translation", {0, 0, 7}}},
                        {{"name", "Armature"}, {"children", {3}}, {"scale", {2, 2, 2}}},
                        {{"name", "Skin"}, {"mesh", 0}},
                        {{"name", "Hips"}, {"translation", {0, 1, 0}}, {"children", {4, 5, 6}}},
                        {{"name", "Spine"}, {"translation", {0, 1, 0}}, {"children", {7, 8}}},
                        {{"name", "Sword"}, {"mesh", 0}},
                        {{"name", "Eye"}, {"camera", 0}},
                        {{"name", "Head"}, {"translation", {0, 1, 0}}},
                        {{"name", "Collar"}, {"mesh", 0}, {"children", {9}}},
                        {{"name", "Bell"}, {"mesh", 0}}};
  for (auto& channel : file.json["animations"][0]["channels"]) channel["target"]["node"] = 3;
  const auto read = ReadGltf(file);
  std::string names;
  for (const core::Joint& joint : Joints(read).skeleton->joints()) names += joint.name + " ";
  CHECK(names == "Hips Spine Head ");
  // The transforms of nodes that are left out apply.
  CHECK(Near(PositionOf(Joints(read), "Hips", 0), {0, -7, 2}));
  CHECK(Near(PositionOf(Joints(read), "Head", 0), {0, -7, 6}));

  // Two nodes that move need their common root.
  file.json["animations"][0]["channels"].push_back(file.json["animations"][0]["channels"][0]);
  file.json["animations"][0]["channels"][1]["target"]["node"] = 2;
  CHECK(Joints(ReadGltf(file)).skeleton->joints()[0].name == "Scene");
}

TEST_CASE("Scene: files without animated skeleton say what they have", "[import][scene]") {
  GltfFile file = NoddingFigure(5);
  file.json["animations"].clear();
  CHECK(ErrorMessageOf(ReadGltf(file)) == "walk.glb: has no animation: 0 meshes, 2 nodes");
  GltfFile outside = NoddingFigure(5);
  outside.json["buffers"][0]["uri"] = "walk data.bin";
  CHECK(ErrorMessageOf(ReadGltf(outside)) ==
        "walk.glb: refers to the file 'walk data.bin': use .glb or embed its buffers");
  GltfFile old = NoddingFigure(5);
  old.json["asset"]["version"] = "1.0";
  CHECK_THAT(ErrorMessageOf(ReadGltf(old)), Contains("convert it to glTF 2.0"));
  GltfFile twins = NoddingFigure(5);
  twins.json["nodes"][1]["name"] = "Hips";
  CHECK_THAT(ErrorMessageOf(ReadGltf(twins)), Contains("several nodes have the name 'Hips'"));
}

}  // namespace motiondb::tests::scene_reader_test
