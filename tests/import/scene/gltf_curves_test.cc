// Interpolation of glTF keys that assimp 5.2 loses.
#include <Eigen/Geometry>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "core/motion/forward_kinematics.h"
#include "tests/import/imported.h"
#include "tests/import/scene/scene_files.h"

namespace motiondb::tests::gltf_curves_test {
namespace {

using core::FileFormat;
using Eigen::Vector3d;

constexpr double kRate_hz = 30;  // of motion with sparse keys

absl::StatusOr<core::MotionFile> ReadCurves(const std::string& bytes) {
  return ReadSceneBytes(FileFormat::kGltf, bytes);
}

// Position of a joint in the file's axes, y up.
Vector3d FilePosition(const core::JointMotion& motion, std::string_view joint, Eigen::Index frame) {
  const Vector3d world = PositionOf(motion, joint, frame);
  return {world.x(), world.z(), -world.y()};
}

// Hips and head, without animation.
GltfFile Figure() {
  GltfFile file = NoddingFigure(2);
  file.json["animations"].clear();
  return file;
}

// A polynomial of degree 3 in each of `Width` coordinates.
template <int Width>
struct Cubic {
  using Vector = Eigen::Matrix<double, Width, 1>;
  std::array<Vector, 4> factors;

  Vector At(double t) const {
    return factors[0] + t * (factors[1] + t * (factors[2] + t * factors[3]));
  }
  Vector SlopeAt(double t) const { return factors[1] + t * (2 * factors[2] + t * 3 * factors[3]); }

  // Keys of a spline: tangent, value, tangent.
  std::vector<float> Keys(const std::vector<float>& times) const {
    std::vector<float> numbers;
    for (const float t : times) {
      for (const Vector& v : {SlopeAt(t), At(t), SlopeAt(t)}) {
        for (const double x : v) numbers.push_back(static_cast<float>(x));
      }
    }
    return numbers;
  }
};

template <int Width>
Cubic<Width> RandomCubic(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> number(-size, size);
  Cubic<Width> cubic;
  for (auto& factor : cubic.factors) {
    for (double& x : factor) x = number(random);
  }
  return cubic;
}

}  // namespace

TEST_CASE("glTF curves: cubic splines equal the polynomials they are made of", "[import][scene]") {
  std::mt19937 random(7);
  for (int round = 0; round < 20; ++round) {
    Cubic<3> moves = RandomCubic<3>(random, 0.3);
    moves.factors[0] = {0, 1, 0};
    Cubic<4> turns = RandomCubic<4>(random, 0.2);
    turns.factors[0] = {0, 0, 0, 1};
    const std::vector<float> times = {0, 0.3F, 0.5F, 1};
    GltfFile file = Figure();
    const int take = file.AddTake("Spline");
    file.AddChannel(take, 0, "translation", times, moves.Keys(times), "CUBICSPLINE");
    file.AddChannel(take, 0, "rotation", times, turns.Keys(times), "CUBICSPLINE");
    for (const std::string& bytes : {file.Text(), file.Binary()}) {
      const auto read = ReadCurves(bytes);
      const core::JointMotion& motion = Joints(read);
      REQUIRE(motion.angles.rows() == 31);
      CHECK(motion.frame_rate_hz == kRate_hz);
      for (int frame = 0; frame < 31; ++frame) {
        const double t = frame / kRate_hz;
        const Vector3d hips = moves.At(t);
        const Vector3d head =
            hips + Eigen::Quaterniond(turns.At(t)).normalized() * Vector3d(0, 0.5, 0);
        INFO("round " << round << ", frame " << frame);
        CHECK((FilePosition(motion, "Hips", frame) - hips).norm() < 1e-5);
        CHECK((FilePosition(motion, "Head", frame) - head).norm() < 1e-5);
      }
    }
  }
}

TEST_CASE("glTF curves: steps hold each value until the next key", "[import][scene]") {
  GltfFile file = Figure();
  const int take = file.AddTake("Steps");
  const std::vector<float> times = {0, 0.5F, 1};
  file.AddChannel(take, 0, "translation", times, {0, 1, 0, 0, 2, 0, 0, 3, 0}, "STEP");
  const auto read = ReadCurves(file.Text());
  const core::JointMotion& motion = Joints(read);
  REQUIRE(motion.angles.rows() == 31);
  for (int frame = 0; frame < 31; ++frame) {
    const double height = frame < 15 ? 1 : (frame < 30 ? 2 : 3);
    INFO("frame " << frame);
    CHECK(std::abs(FilePosition(motion, "Hips", frame).y() - height) < 1e-6);
  }
}

TEST_CASE("glTF curves: rotations as normalized integers", "[import][scene]") {
  GltfFile floats = NoddingFigure(5);
  GltfFile integers = floats;
  std::vector<float> turns;
  for (int i = 0; i < 5; ++i) {
    const float half = 0.05F * static_cast<float>(i);
    turns.insert(turns.end(), {std::sin(half), 0, 0, std::cos(half)});
  }
  integers.json["animations"][0]["samplers"][0]["output"] = integers.AddShorts(turns, 4);
  const auto expected = ReadCurves(floats.Text());
  const auto read = ReadCurves(integers.Text());
  REQUIRE(Joints(read).angles.rows() == 5);
  CHECK((core::JointPositions(Joints(read)) - core::JointPositions(Joints(expected)))
            .cwiseAbs()
            .maxCoeff() < 1e-4);
}

TEST_CASE("glTF curves: values that cannot be read are named", "[import][scene]") {
  using Catch::Contains;
  const std::vector<float> times = {0, 0.5F};
  const auto spline = [&] {
    GltfFile file = Figure();
    file.AddChannel(file.AddTake("A"), 0, "translation", times, std::vector<float>(18, 1.0F),
                    "CUBICSPLINE");
    return file;
  };
  CHECK(ReadCurves(spline().Text()).ok());

  GltfFile few = Figure();
  few.AddChannel(few.AddTake("A"), 0, "translation", times, std::vector<float>(6, 1.0F),
                 "CUBICSPLINE");
  CHECK_THAT(ErrorMessageOf(ReadCurves(few.Text())), Contains("count: expected 6 for 2 times"));

  GltfFile unknown = spline();
  unknown.json["animations"][0]["samplers"][0]["interpolation"] = "BEZIER";
  CHECK_THAT(ErrorMessageOf(ReadCurves(unknown.Text())),
             Contains("animations[0].channels[0]: interpolation: expected LINEAR, STEP or "
                      "CUBICSPLINE, found \"BEZIER\""));

  GltfFile sparse = spline();
  sparse.json["accessors"].back()["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", 0}, {"componentType", 5125}}},
      {"values", {{"bufferView", 0}}}};
  CHECK_FALSE(ReadCurves(sparse.Text()).ok());
}

}  // namespace motiondb::tests::gltf_curves_test
