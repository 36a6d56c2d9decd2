#include "import/npz/npz_reader.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "core/export/writers.h"
#include "core/motion/forward_kinematics.h"
#include "tests/import/imported.h"
#include "tests/import/npz/npz_files.h"
#include "tests/import/npz/smpl_walk.h"
#include "tests/support/real_data.h"
#include "tests/support/stick_figure.h"

namespace motiondb::tests::npz_reader_test {
namespace {

using Catch::Contains;
using Eigen::Vector3d;
using importer::SmplModel;

// Returns the maximum distance of joints of the same index, m.
double MaxDistance(const core::JointMotion& a, const core::JointMotion& b) {
  REQUIRE(a.angles.rows() == b.angles.rows());
  REQUIRE(a.skeleton->joint_count() == b.skeleton->joint_count());
  double max_distance = 0;
  for (Eigen::Index frame = 0; frame < a.angles.rows(); ++frame) {
    const auto p = core::ForwardKinematics(*a.skeleton, a.angles.row(frame));
    const auto q = core::ForwardKinematics(*b.skeleton, b.angles.row(frame));
    for (std::size_t j = 0; j < p.size(); ++j) {
      max_distance = std::max(max_distance, (p[j].translation() - q[j].translation()).norm());
      max_distance = std::max(max_distance, (p[j].linear() - q[j].linear()).norm());
    }
  }
  return max_distance;
}

}  // namespace

TEST_CASE("ReadNpz: a written motion comes back", "[import]") {
  const auto check = [](const core::JointMotion& motion) {
    const auto bytes = core::WriteNpz(motion);
    INFO(MessageOf(bytes.status()));
    REQUIRE(bytes.ok());
    const auto file = ReadNpzBytes(*bytes);
    const core::JointMotion& read = Joints(file);
    CHECK(read.frame_rate_hz == motion.frame_rate_hz);
    CHECK(MaxDistance(motion, read) < 1e-9);
    CHECK(file->report.unit_provenance == core::Provenance::kStated);
    CHECK(file->report.notes.empty());
    for (int j = 0; j < read.skeleton->joint_count(); ++j) {
      CHECK(read.skeleton->joints()[j].name == motion.skeleton->joints()[j].name);
      CHECK(read.skeleton->joints()[j].parent == motion.skeleton->joints()[j].parent);
    }
    // Only the root slides.
    CHECK(read.skeleton->dof_count() == 3 + 3 * read.skeleton->joint_count());
    // Zero angles are the same pose, but for the place of the root.
    const auto rest = core::ForwardKinematics(
        *motion.skeleton, Eigen::RowVectorXd::Zero(motion.skeleton->dof_count()));
    const auto read_rest = core::ForwardKinematics(
        *read.skeleton, Eigen::RowVectorXd::Zero(read.skeleton->dof_count()));
    for (std::size_t j = 0; j < rest.size(); ++j) {
      CHECK((rest[j].translation() - read_rest[j].translation()).norm() < 1e-9);
    }
    return MaxStep(read.angles);
  };
  for (const Act act : {Act::kWalk, Act::kSquat, Act::kWave}) {
    CHECK(check(Joints(ReadText(core::FileFormat::kBvh,
                                WriteBvh(StickFigure{.act = act, .frame_count = 90})))) < 0.5);
  }
  MOTIONDB_REQUIRE_DATA();
  const std::string asf = ReadFile(DataDir() / "cmu/02/02.asf");
  const std::string amc = ReadFile(DataDir() / "cmu/02/02_01.amc");
  const auto walk = core::ReadMotionFile(core::FileFormat::kAmc, {.name = "amc", .bytes = amc},
                                         core::SourceFile{.name = "asf", .bytes = asf});
  CHECK(check(Joints(walk)) < 0.5);
}

TEST_CASE("ReadNpz: joints that slide, and any chain of rotations", "[import]") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(-3, 3);
  const auto turn = [&] { return Rodrigues({number(random), number(random), number(random)}); };
  std::vector<core::Joint> joints;
  for (int j = 0; j < 12; ++j) {
    core::Joint joint{.name = fmt::format("j{}", j),
                      .parent = j % 5 == 0 ? -1 : j - 1,
                      .offset_m = {number(random), number(random), number(random)},
                      .pre_rotation = turn(),
                      .post_rotation = turn()};
    if (j % 3 == 0) joint.dofs.push_back({.kind = core::Dof::Kind::kTranslation});
    for (int k = 0; k < j % 4; ++k) {
      joint.dofs.push_back(
          {.kind = core::Dof::Kind::kRotation, .axis = turn() * Vector3d::UnitX()});
    }
    joints.push_back(std::move(joint));
  }
  auto skeleton = core::Skeleton::Create("chain", std::move(joints));
  REQUIRE(skeleton.ok());
  core::JointMotion motion{std::make_shared<core::Skeleton>(*std::move(skeleton)), 100, {}};
  motion.angles.resize(80, motion.skeleton->dof_count());
  for (Eigen::Index i = 0; i < motion.angles.size(); ++i) motion.angles.data()[i] = number(random);
  const auto bytes = core::WriteNpz(motion);
  REQUIRE(bytes.ok());
  const auto file = ReadNpzBytes(*bytes);
  CHECK(MaxDistance(motion, Joints(file)) < 1e-9);
  CHECK(Joints(file).skeleton->joint_count() == 12);
  // Roots 0, 5 and 10, and joints 3, 6 and 9.
  CHECK(Joints(file).skeleton->dof_count() == 3 * 12 + 3 * 6);
}

TEST_CASE("ReadNpz: written markers come back", "[import]") {
  core::MarkerMotion motion{
      .names = {"LFHD", "C7", "\xc3\x84"}, .frame_rate_hz = 119.88, .positions_m = {}};
  motion.positions_m = core::FrameMatrix::Random(50, 9);
  motion.positions_m.block<20, 3>(10, 3).setConstant(std::numeric_limits<float>::quiet_NaN());
  const auto bytes = core::WriteNpz(motion);
  REQUIRE(bytes.ok());
  const auto file = ReadNpzBytes(*bytes);
  const core::MarkerMotion& read = Markers(file);
  CHECK(read.names == motion.names);
  CHECK(read.frame_rate_hz == motion.frame_rate_hz);
  REQUIRE(read.positions_m.rows() == 50);
  CHECK(read.positions_m.block<20, 3>(10, 3).array().isNaN().all());
  const auto numbers = [](const core::FrameMatrix& m) -> core::FrameMatrix {
    return m.array().isNaN().select(0.0F, m);
  };
  CHECK(numbers(read.positions_m) == numbers(motion.positions_m));
}

TEST_CASE("ReadNpz: options convert motiondb's archives too", "[import]") {
  const core::JointMotion motion =
      Joints(ReadText(core::FileFormat::kBvh, WriteBvh(tests::Walk(0))));
  const auto bytes = core::WriteNpz(motion);
  REQUIRE(bytes.ok());
  Eigen::Matrix3d from_y_up;
  from_y_up << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  const auto file = ReadNpzBytes(*bytes, {.metres_per_unit = 2, .up_axis = core::UpAxis::kY});
  const auto before = core::ForwardKinematics(*motion.skeleton, motion.angles.row(20));
  const auto after = core::ForwardKinematics(*Joints(file).skeleton, Joints(file).angles.row(20));
  for (std::size_t j = 0; j < before.size(); ++j) {
    CHECK((after[j].translation() - 2 * from_y_up * before[j].translation()).norm() < 1e-9);
  }
}

TEST_CASE("ReadNpz: errors of motiondb's archives", "[import]") {
  const NpzArrays good = {
      {"motiondb_version", Float64Npy({}, {1})},
      {"frame_rate_hz", Float64Npy({}, {60})},
      {"joint_names", Npy(NpyDictionary("|S1", {2}), "ab")},
      {"parents", Npy(NpyDictionary("|i1", {2}), BytesOf<std::int8_t>({-1, 0}))},
      {"offsets_m", Float64Npy({2, 3}, {0, 0, 0, 0, 0, 1})},
      {"local_rotations", Float64Npy({1, 2, 4}, {0, 0, 0, 1, 0, 0, 0, 1})},
      {"local_positions_m", Float64Npy({1, 2, 3}, {0, 0, 0, 0, 0, 1})}};
  CHECK(Joints(ReadNpzBytes(NpzOf(good))).skeleton->joint_count() == 2);
  const auto check = [&](const std::string& name, const std::string& npy,
                         const std::string& expected) {
    NpzArrays arrays = good;
    arrays[name] = npy;
    if (npy.empty()) arrays.erase(name);
    const std::string message = ErrorMessageOf(ReadNpzBytes(NpzOf(arrays)));
    CHECK_THAT(message, Catch::StartsWith("walk.npz: "));
    CHECK_THAT(message, Contains(expected));
  };
  check("motiondb_version", Float64Npy({}, {2}), "'motiondb_version': expected 1, found 2");
  check("frame_rate_hz", Float64Npy({}, {-1}), "'frame_rate_hz': expected a frame rate");
  check("frame_rate_hz", "", "expected the array 'frame_rate_hz' of motiondb; found joint_names");
  check("joint_names", "", "expected the array 'joint_names' of motiondb");
  check("joint_names", Npy(NpyDictionary("|S1", {2}), std::string("a\0", 2)), "name 1 is empty");
  check("joint_names", Float64Npy({2}, {1, 2}), "expected a list of texts");
  check("joint_names", Npy(NpyDictionary("|S1", {0}), ""), "expected 1 to 2000 joints, found 0");
  check("parents", "", "expected the array 'parents'");
  for (const double parent : {1.0, -2.0, 0.5, 7.0}) {
    check("parents", Float64Npy({2}, {-1, parent}),
          "array 'parents': joint 1: expected -1 or a joint before it");
  }
  check("parents", Float64Npy({3}, {-1, 0, 0}), "expected 2 numbers, found the shape (3)");
  check("offsets_m", Float64Npy({1, 3}, {0, 0, 0}), "expected 2 rows in 'offsets_m'");
  check("rest_rotations", Float64Npy({1, 4}, {0, 0, 0, 1}), "expected 2 rows");
  check("rest_rotations", Float64Npy({2, 4}, {0, 0, 0, 1, 0, 0, 0, 2}),
        "array 'rest_rotations': row 1, column 0: expected a quaternion of norm 1, found 2");
  check("local_rotations", Float64Npy({1, 2, 4}, {0, 0, 0, 1, 0, 0, 0, 0}),
        "array 'local_rotations': row 0, column 4: expected a quaternion of norm 1, found 0");
  check("local_rotations", Float64Npy({1, 3, 4}, std::vector<double>(12)),
        "expected at least one frame of 8 numbers, found the shape (1, 3, 4)");
  check("local_positions_m", Float64Npy({2, 2, 3}, std::vector<double>(12)),
        "array 'local_positions_m': expected 1 frames");
  check("local_positions_m", Float64Npy({1, 2, 3}, {0, 0, 0, NAN, 0, 1}),
        "array 'local_positions_m': frame 0, column 3: expected a finite number, found nan");

  const auto markers = [](const std::vector<double>& positions) {
    return NpzOf({{"motiondb_version", Float64Npy({}, {1})},
                  {"frame_rate_hz", Float64Npy({}, {60})},
                  {"marker_names", Npy(NpyDictionary("|S1", {1}), "a")},
                  {"positions_m", Float64Npy({1, positions.size() / 3, 3}, positions)}});
  };
  CHECK(ReadNpzBytes(markers({1, 2, 3})).ok());
  CHECK_THAT(ErrorMessageOf(ReadNpzBytes(markers({1, 2, NAN}))),
             Contains("frame 0, column 0: expected all three coordinates of marker 'a' or none"));
  CHECK_THAT(ErrorMessageOf(ReadNpzBytes(markers({1, 2, 3, 4, 5, 6}))),
             Contains("one frame of 3 numbers"));
}

TEST_CASE("ReadNpz: truncated and corrupt archives are rejected or read", "[import]") {
  NpzArrays small = AmassWalk(SmplModel::kSmpl);
  for (auto& [name, npy] : small) {
    if (name == "poses") npy = Float64Npy({4, 72}, std::vector<double>(4 * 72, 0.1));
    if (name == "trans") npy = Float64Npy({4, 3}, std::vector<double>(12, 0.5));
    if (name == "dmpls") npy = Float64Npy({1}, {1});
  }
  const auto written = core::WriteNpz(Joints(ReadNpzBytes(NpzOf(small))));
  REQUIRE(written.ok());
  std::mt19937 random(9);
  for (const std::string& bytes : {NpzOf(small), *written}) {
    REQUIRE(ReadNpzBytes(bytes).ok());
    for (std::size_t size = 0; size < bytes.size(); size += 50) {
      CAPTURE(size);
      CHECK_THAT(ErrorMessageOf(ReadNpzBytes(bytes.substr(0, size))),
                 Catch::StartsWith("walk.npz: "));
    }
    for (int i = 0; i < 1000; ++i) {
      std::string corrupt = bytes;
      for (int k = 0; k < 1 + i % 3; ++k) {
        corrupt[random() % corrupt.size()] = static_cast<char>(random());
      }
      ReadNpzBytes(corrupt).IgnoreError();  // under the sanitizers
    }
  }
  // Corrupt arrays with right checksums.
  for (int i = 0; i < 2000; ++i) {
    NpzArrays corrupt = small;
    auto at = corrupt.begin();
    std::advance(at, static_cast<std::ptrdiff_t>(random() % corrupt.size()));
    at->second[random() % std::min<std::size_t>(at->second.size(), 100)] =
        static_cast<char>(random());
    ReadNpzBytes(NpzOf(corrupt)).IgnoreError();
  }
}

}  // namespace motiondb::tests::npz_reader_test
