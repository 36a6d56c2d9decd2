#include <zlib.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <numbers>
#include <string_view>

#include "core/export/writers.h"
#include "core/motion/forward_kinematics.h"
#include "tests/core/format/reading.h"

namespace motiondb::tests::npz_writer_test {
namespace {

using Catch::Contains;
using core::Dof;
using Eigen::Vector3d;

// A figure of two joints in two frames: the root slides and turns, its child turns.
core::JointMotion TwoJoints() {
  auto skeleton = core::Skeleton::Create(
      "figure", {{.name = "hips",
                  .offset_m = {0, 0, 1},
                  .dofs = {{.kind = Dof::Kind::kTranslation, .axis = Vector3d::UnitX()},
                           {.kind = Dof::Kind::kRotation, .axis = Vector3d::UnitZ()}}},
                 {.name = "kn\xc3\xa9",
                  .parent = 0,
                  .offset_m = {0, 0.5, 0},
                  .dofs = {{.kind = Dof::Kind::kRotation, .axis = Vector3d::UnitX()}}}});
  REQUIRE(skeleton.ok());
  core::JointMotion motion{std::make_shared<core::Skeleton>(*std::move(skeleton)), 120,
                           core::JointMatrix::Zero(2, 3)};
  motion.angles << 0, 0, 0, 2, std::numbers::pi / 2, std::numbers::pi;
  return motion;
}

core::MarkerMotion TwoMarkers() {
  core::MarkerMotion motion{.names = {"LFHD", "RFHD"}, .frame_rate_hz = 50, .positions_m = {}};
  motion.positions_m.resize(2, 6);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  motion.positions_m << 0.1F, 0.2F, 1.5F, kNan, kNan, kNan, 0, -1, 2, 3, 4, 5;
  return motion;
}

std::uint64_t IntegerAt(std::string_view bytes, std::size_t at, int count) {
  std::uint64_t value = 0;
  for (int i = count; i-- > 0;) {
    value = value << 8 | static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(i)]);
  }
  return value;
}

struct Array {
  std::string header;  // the dictionary, without padding
  std::string data;
  bool operator==(const Array&) const = default;
};

// Walks the local headers of a stored zip archive, checks them against the directory, and returns
// the arrays by name.
std::vector<std::pair<std::string, Array>> ArraysOf(std::string_view zip) {
  constexpr std::size_t kEnd = 22;
  const std::size_t end = zip.size() - kEnd;
  REQUIRE(zip.substr(end, 4) == std::string_view("PK\x05\x06", 4));
  std::size_t entry = IntegerAt(zip, end + 16, 4);
  REQUIRE(entry + IntegerAt(zip, end + 12, 4) == end);
  std::vector<std::pair<std::string, Array>> arrays;
  std::size_t at = 0;
  for (std::uint64_t i = 0; i < IntegerAt(zip, end + 10, 2); ++i) {
    REQUIRE(zip.substr(at, 4) == std::string_view("PK\x03\x04", 4));
    REQUIRE(zip.substr(entry, 4) == std::string_view("PK\x01\x02", 4));
    CHECK(zip.substr(at + 4, 26) == zip.substr(entry + 6, 26));
    CHECK(IntegerAt(zip, entry + 42, 4) == at);
    CHECK(IntegerAt(zip, at + 8, 2) == 0);        // stored
    CHECK(IntegerAt(zip, at + 12, 2) == 0x0021);  // 1980-01-01
    const std::size_t size = IntegerAt(zip, at + 18, 4);
    CHECK(size == IntegerAt(zip, at + 22, 4));
    const std::size_t name_size = IntegerAt(zip, at + 26, 2);
    const std::string_view name = zip.substr(at + 30, name_size);
    CHECK(name == zip.substr(entry + 46, name_size));
    REQUIRE(name.ends_with(".npy"));
    const std::string_view npy = zip.substr(at + 30 + name_size, size);
    CHECK(crc32(0, reinterpret_cast<const Bytef*>(npy.data()), static_cast<uInt>(size)) ==
          IntegerAt(zip, at + 14, 4));

    REQUIRE(npy.substr(0, 8) == std::string_view("\x93NUMPY\x01\x00", 8));
    const std::size_t data = 10 + IntegerAt(npy, 8, 2);
    CHECK(data % 64 == 0);
    CHECK(npy[data - 1] == '\n');
    std::string header(npy.substr(10, data - 11));
    header.erase(header.find_last_not_of(' ') + 1);
    arrays.emplace_back(std::string(name.substr(0, name.size() - 4)),
                        Array{std::move(header), std::string(npy.substr(data))});
    at += 30 + name_size + size;
    entry += 46 + name_size;
  }
  CHECK(entry == end);
  return arrays;
}

template <typename T>
std::string Bytes(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

// Returns the numbers of an array of float64, rounded to 1e-12.
std::vector<double> Rounded(const std::string& data) {
  std::vector<double> numbers(data.size() / sizeof(double));
  std::memcpy(numbers.data(), data.data(), data.size());
  for (double& number : numbers) number = std::round(number * 1e12) / 1e12 + 0.0;
  return numbers;
}

std::string Dictionary(const std::string& type, const std::string& shape) {
  return "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + shape + "), }";
}

}  // namespace

TEST_CASE("WriteNpz: exact arrays of joints", "[core][format]") {
  const auto bytes = core::WriteNpz(TwoJoints());
  INFO(MessageOf(bytes.status()));
  REQUIRE(bytes.ok());
  const auto listed = ArraysOf(*bytes);
  std::map<std::string, Array> arrays(listed.begin(), listed.end());
  REQUIRE(listed.size() == 9);
  CHECK(listed.front().first == "motiondb_version");
  CHECK(arrays.at("motiondb_version") == Array{Dictionary("<i4", ""), Bytes<std::int32_t>({1})});
  CHECK(arrays.at("frame_rate_hz") == Array{Dictionary("<f8", ""), Bytes<double>({120})});
  CHECK(arrays.at("joint_names") ==
        Array{Dictionary("<U4", "2,"),
              Bytes<char32_t>({U'h', U'i', U'p', U's', U'k', U'n', U'\u00e9', 0})});
  CHECK(arrays.at("parents") == Array{Dictionary("<i4", "2,"), Bytes<std::int32_t>({-1, 0})});
  CHECK(arrays.at("offsets_m") ==
        Array{Dictionary("<f8", "2,3,"), Bytes<double>({0, 0, 1, 0, 0.5, 0})});
  CHECK(arrays.at("rest_rotations") ==
        Array{Dictionary("<f8", "2,4,"), Bytes<double>({0, 0, 0, 1, 0, 0, 0, 1})});

  const double half = std::round(std::sqrt(0.5) * 1e12) / 1e12;
  CHECK(arrays.at("local_rotations").header == Dictionary("<f8", "2,2,4,"));
  CHECK(Rounded(arrays.at("local_rotations").data) ==
        std::vector<double>{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, half, half, 1, 0, 0, 0});
  CHECK(arrays.at("local_positions_m").header == Dictionary("<f8", "2,2,3,"));
  CHECK(Rounded(arrays.at("local_positions_m").data) ==
        std::vector<double>{0, 0, 1, 0, 0.5, 0, 2, 0, 1, 0, 0.5, 0});
  CHECK(arrays.at("positions_m").header == Dictionary("<f8", "2,2,3,"));
  CHECK(Rounded(arrays.at("positions_m").data) ==
        std::vector<double>{0, 0, 1, 0, 0.5, 1, 2, 0, 1, 1.5, 0, 1});
  CHECK(*core::WriteNpz(TwoJoints()) == *bytes);
}

TEST_CASE("WriteNpz: quaternions are continuous", "[core][format]") {
  core::JointMotion motion = TwoJoints();
  motion.angles.resize(100, 3);
  for (int frame = 0; frame < 100; ++frame) motion.angles.row(frame) << 0, 0.2 * frame, 0;
  const auto bytes = core::WriteNpz(motion);
  REQUIRE(bytes.ok());
  for (const auto& [name, array] : ArraysOf(*bytes)) {
    if (name != "local_rotations") continue;
    const std::vector<double> q = Rounded(array.data);
    REQUIRE(q.size() == 800);
    for (std::size_t i = 8; i < q.size(); ++i) CHECK(std::abs(q[i] - q[i - 8]) < 0.11);
  }
}

TEST_CASE("WriteNpz: exact arrays of markers", "[core][format]") {
  const core::MarkerMotion motion = TwoMarkers();
  const auto bytes = core::WriteNpz(motion);
  INFO(MessageOf(bytes.status()));
  REQUIRE(bytes.ok());
  const auto listed = ArraysOf(*bytes);
  std::map<std::string, Array> arrays(listed.begin(), listed.end());
  REQUIRE(listed.size() == 4);
  CHECK(arrays.at("frame_rate_hz").data == Bytes<double>({50}));
  CHECK(arrays.at("marker_names").header == Dictionary("<U4", "2,"));
  CHECK(arrays.at("positions_m").header == Dictionary("<f8", "2,2,3,"));
  std::vector<double> positions(12);
  REQUIRE(arrays.at("positions_m").data.size() == 96);
  std::memcpy(positions.data(), arrays.at("positions_m").data.data(), 96);
  for (int i = 0; i < 12; ++i) {
    const float expected = motion.positions_m.data()[i];
    if (std::isnan(expected)) {
      CHECK(std::isnan(positions[i]));
    } else {
      CHECK(positions[i] == static_cast<double>(expected));
    }
  }
}

TEST_CASE("WriteNpz: an invalid motion is rejected", "[core][format]") {
  const auto error = [](core::Motion motion) {
    const std::string message = ErrorMessageOf(core::WriteNpz(motion));
    CHECK_THAT(message, Catch::StartsWith("NPZ: "));
    return message;
  };
  core::JointMotion joints = TwoJoints();
  joints.angles(1, 1) = std::numeric_limits<double>::infinity();
  CHECK_THAT(error(joints), Contains("frame 1 has a joint angle that is not finite"));
  joints = TwoJoints();
  joints.angles.resize(0, 3);
  CHECK_THAT(error(joints), Contains("has no frame"));
  joints = TwoJoints();
  joints.frame_rate_hz = 0;
  CHECK_THAT(error(joints), Contains("expected a frame rate"));
  joints = TwoJoints();
  joints.skeleton = nullptr;
  CHECK_THAT(error(joints), Contains("has no skeleton"));
  joints = TwoJoints();
  auto skewed = core::Skeleton::Create(
      "skewed", {{.name = "hips", .pre_rotation = 2 * Eigen::Matrix3d::Identity(), .dofs = {}}});
  REQUIRE(skewed.ok());
  joints.skeleton = std::make_shared<core::Skeleton>(*std::move(skewed));
  joints.angles.resize(1, 0);
  CHECK_THAT(error(joints), Contains("the transform of joint 'hips' is not a rotation in frame 0"));

  core::MarkerMotion markers = TwoMarkers();
  markers.positions_m(1, 4) = std::numeric_limits<float>::quiet_NaN();
  CHECK_THAT(error(markers), Contains("frame 1: expected all three coordinates of 'RFHD' or none"));
  markers = TwoMarkers();
  markers.positions_m(1, 4) = std::numeric_limits<float>::infinity();
  CHECK_THAT(error(markers), Contains("frame 1: expected coordinates of 'RFHD' of at most"));
  markers = TwoMarkers();
  markers.names.pop_back();
  CHECK_THAT(error(markers), Contains("expected 3 columns, three a point, found 6"));
  markers = TwoMarkers();
  markers.names[1] = markers.names[0];
  CHECK_THAT(error(markers), Contains("two points are named 'LFHD'"));
  CHECK_THAT(error(core::MarkerMotion{}), Contains("has no point"));
  markers = TwoMarkers();
  markers.positions_m.resize(0, 6);
  CHECK_THAT(error(markers), Contains("has no frame"));
  markers = TwoMarkers();
  markers.frame_rate_hz = -1;
  CHECK_THAT(error(markers), Contains("expected a frame rate"));
}

}  // namespace motiondb::tests::npz_writer_test
