#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "core/export/writers.h"
#include "tests/core/format/reading.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::c3d_writer_test {
namespace {

using Catch::Contains;
using core::MarkerMotion;

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

// Positions within 4 m of the origin; every fifth point is missing.
MarkerMotion RandomMarkers(std::size_t markers, int frames, double rate_hz) {
  MarkerMotion motion;
  for (std::size_t m = 0; m < markers; ++m) motion.names.push_back("marker " + std::to_string(m));
  motion.frame_rate_hz = rate_hz;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> value(-4, 4);
  motion.positions_m = core::FrameMatrix::NullaryExpr(
      frames, 3 * static_cast<Eigen::Index>(markers), [&] { return value(random); });
  for (Eigen::Index point = 0; point < motion.positions_m.size() / 3; point += 5) {
    for (int axis = 0; axis < 3; ++axis) motion.positions_m.data()[3 * point + axis] = kMissing;
  }
  return motion;
}

std::string Written(const MarkerMotion& motion) {
  auto bytes = core::WriteC3d(motion);
  INFO(MessageOf(bytes.status()));
  REQUIRE(bytes.ok());
  return *std::move(bytes);
}

std::string RefusalOf(const MarkerMotion& motion) { return ErrorMessageOf(core::WriteC3d(motion)); }

void CheckRoundTrip(const MarkerMotion& motion) {
  const std::string bytes = Written(motion);
  const auto file = ReadText(core::FileFormat::kC3d, bytes);
  const MarkerMotion& read = Markers(file);
  CHECK(core::Describe(file->report) == "unit 0.001 m (stated), z up (stated)");
  CHECK(read.names == motion.names);
  CHECK(read.frame_rate_hz == Approx(motion.frame_rate_hz).epsilon(1e-6));
  REQUIRE(read.positions_m.rows() == motion.positions_m.rows());
  REQUIRE(read.positions_m.cols() == motion.positions_m.cols());
  const auto was = motion.positions_m.array();
  const auto is = read.positions_m.array();
  CHECK((was.isNaN() == is.isNaN()).all());
  CHECK((was.isNaN() || (was - is).abs() < 1e-6F).all());
}

std::uint16_t WordAt(const std::string& bytes, std::size_t offset) {
  return static_cast<std::uint16_t>(static_cast<std::uint8_t>(bytes.at(offset)) |
                                    static_cast<std::uint8_t>(bytes.at(offset + 1)) << 8);
}

float RealAt(const std::string& bytes, std::size_t offset) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(WordAt(bytes, offset)) |
                              static_cast<std::uint32_t>(WordAt(bytes, offset + 2)) << 16);
}

}  // namespace

TEST_CASE("WriteC3d: markers are read back, with gaps, names and rate", "[core][format]") {
  CheckRoundTrip(RandomMarkers(40, 100, 120));
  CheckRoundTrip(RandomMarkers(1, 1, 29.97));
}

TEST_CASE("WriteC3d: recorded markers are read back", "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  for (const char* path : {"formats/same-motion/02_01.c3d", "formats/c3d/sample02_pc_int.c3d"}) {
    CAPTURE(path);
    CheckRoundTrip(Markers(ReadText(core::FileFormat::kC3d, ReadFile(DataDir() / path))));
  }
}

TEST_CASE("WriteC3d: header and data follow the format", "[core][format]") {
  MarkerMotion motion = RandomMarkers(2, 3, 50);
  motion.positions_m.row(1) << 1, -2, 0.5F, kMissing, kMissing, kMissing;
  const std::string bytes = Written(motion);
  CHECK(bytes.size() % 512 == 0);
  CHECK(bytes.substr(0, 2) == "\x02\x50");
  CHECK(WordAt(bytes, 2) == 2);  // points
  CHECK(WordAt(bytes, 4) == 0);  // analog samples
  CHECK(WordAt(bytes, 6) == 1);  // first frame
  CHECK(WordAt(bytes, 8) == 3);  // last frame
  CHECK(RealAt(bytes, 12) < 0);  // real numbers
  CHECK(RealAt(bytes, 20) == 50);
  CHECK(bytes.at(515) == 84);  // Intel
  const auto blocks = static_cast<std::uint8_t>(bytes.at(514));
  CHECK(WordAt(bytes, 16) == 2 + blocks);
  const std::size_t second_frame = 512U * (1U + blocks) + 2 * 16;
  const float expected[] = {1000, -2000, 500, 0, 0, 0, 0, -1};
  for (std::size_t i = 0; i < 8; ++i) {
    CHECK(RealAt(bytes, second_frame + 4 * i) == expected[i]);
  }
}

TEST_CASE("WriteC3d: the parameter section is a list with a zero at its end", "[core][format]") {
  std::set<std::size_t> unused;  // bytes at the end of the last block
  for (std::size_t markers = 1; markers <= 3; ++markers) {
    for (std::size_t length = 1; length <= 255; ++length) {
      MarkerMotion motion = RandomMarkers(markers, 1, 100);
      motion.names[0] = std::string(length, 'a');
      const std::string bytes = Written(motion);
      const std::size_t end = 512U * (1U + static_cast<std::uint8_t>(bytes.at(514)));
      std::set<std::string> names;
      std::size_t next = 516;
      // The distance to the next entry follows the name.
      while (bytes.at(next) != 0) {
        const std::size_t name_length = static_cast<std::uint8_t>(bytes.at(next));
        names.insert(bytes.substr(next + 2, name_length));
        next += 2 + name_length;
        next += WordAt(bytes, next);
        REQUIRE(next < end);
      }
      unused.insert(end - next);
      CHECK(names.contains("MANUFACTURER"));
      CHECK(names.contains("ACTUAL_END_FIELD"));
      CHECK(names.contains("Y_SCREEN"));
      CheckRoundTrip(motion);
    }
  }
  CHECK(*unused.begin() == 1);
  CHECK(*unused.rbegin() == 512);
}

TEST_CASE("WriteC3d: more than 255 points and 65535 frames", "[core][format]") {
  CheckRoundTrip(RandomMarkers(255, 2, 100));
  CheckRoundTrip(RandomMarkers(256, 2, 100));
  CheckRoundTrip(RandomMarkers(1000, 2, 100));
  for (const int frames : {65'534, 65'535, 65'536, 140'000}) {
    CheckRoundTrip(RandomMarkers(1, frames, 1000));
  }
}

TEST_CASE("WriteC3d: a marker exactly at the origin is not missing", "[core][format]") {
  MarkerMotion motion = RandomMarkers(2, 1, 100);
  motion.positions_m.setZero();
  CheckRoundTrip(motion);
}

TEST_CASE("WriteC3d: a motion of missing markers only", "[core][format]") {
  MarkerMotion motion = RandomMarkers(2, 2, 100);
  motion.positions_m.setConstant(kMissing);
  CHECK(
      Markers(ReadText(core::FileFormat::kC3d, Written(motion))).positions_m.array().isNaN().all());
}

TEST_CASE("WriteC3d: long labels are cut, equal ones refused", "[core][format]") {
  MarkerMotion motion = RandomMarkers(2, 1, 100);
  motion.names = {std::string(255, 'a'), std::string(300, 'b')};
  const auto file = ReadText(core::FileFormat::kC3d, Written(motion));
  CHECK(Markers(file).names == std::vector{std::string(255, 'a'), std::string(255, 'b')});
  motion.names = {std::string(254, 'a') + "\xC3\xA4", "\xC3\xA4"};
  const auto umlaut = ReadText(core::FileFormat::kC3d, Written(motion));
  CHECK(Markers(umlaut).names == std::vector{std::string(254, 'a'), std::string("\xC3\xA4")});
  motion.names = {std::string(255, 'a') + "1", std::string(255, 'a') + "2"};
  CHECK_THAT(RefusalOf(motion), Contains("names with the same first 255 bytes, 'aaa"));
}

TEST_CASE("WriteC3d: motion that the file cannot express is refused", "[core][format]") {
  MarkerMotion motion = RandomMarkers(2, 3, 100);
  motion.frame_rate_hz = 0;
  CHECK_THAT(RefusalOf(motion), Contains("C3D: expected a frame rate"));
  motion = RandomMarkers(2, 3, 100);
  motion.positions_m(2, 0) = INFINITY;
  CHECK_THAT(RefusalOf(motion), Contains("C3D: frame 2") && Contains("marker 0"));
  motion.positions_m(2, 0) = kMissing;
  CHECK_THAT(RefusalOf(motion), Contains("C3D: frame 2") && Contains("marker 0"));
  motion = RandomMarkers(2, 3, 100);
  motion.names.pop_back();
  CHECK_THAT(RefusalOf(motion), Contains("C3D: expected 3 columns"));
  CHECK_THAT(RefusalOf(RandomMarkers(20'000, 1, 100)),
             Contains("the labels of 20000 points need") && Contains("at most 130560"));
  CHECK_THAT(RefusalOf(RandomMarkers(65'536, 1, 100)), Contains("at most 65535 points"));
}

}  // namespace motiondb::tests::c3d_writer_test
