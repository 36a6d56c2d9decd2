#include "server/translate/frames.h"

#include <catch2/catch.hpp>
#include <limits>

#include "server/translate/packed_floats.h"

namespace motiondb::server {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST_CASE("Frames: packed floats come back row by row", "[server][translate]") {
  core::FrameMatrix frames(2, 3);
  frames << 1, 2, 3, 4, 5, 6;
  std::string bytes;
  AppendPacked(frames.data(), 6, bytes);
  CHECK(bytes.substr(0, 4) == std::string("\x00\x00\x80\x3f", 4));  // 1.0, little-endian
  const auto back = FramesFrom("observation.markers", "positions", {2, 3}, bytes);
  REQUIRE(back.ok());
  CHECK(*back == frames);
}

TEST_CASE("Frames: sizes that do not agree are refused before memory is taken",
          "[server][translate]") {
  const auto bad = FramesFrom("m", "positions", {2, 3}, std::string(20, '\0'));
  CHECK(bad.status().message() == "m.positions: expected 24 bytes, 2 frames of 3 float32, got 20");
  CHECK(!FramesFrom("m", "positions", {0, 3}, "").ok());
  CHECK(!FramesFrom("m", "positions", {-1, 3}, "").ok());
  const int huge = std::numeric_limits<int>::max();
  CHECK(!FramesFrom("m", "positions", {huge, 3 * 200}, std::string(24, '\0')).ok());
}

TEST_CASE("Frames: a marker is finite or missing in all three", "[server][translate]") {
  core::MarkerMotion motion{{"A", "B"}, 60, core::FrameMatrix::Zero(2, 6)};
  CHECK(CheckMarkers("m", motion.names, motion.positions_m).ok());
  motion.positions_m.row(1).segment<3>(3).setConstant(kNan);
  CHECK(CheckMarkers("m", motion.names, motion.positions_m).ok());
  motion.positions_m(1, 4) = 0;
  const std::string message(CheckMarkers("m", motion.names, motion.positions_m).message());
  CHECK(message.find("frame 1, marker 'B'") != std::string::npos);
  motion.positions_m.row(1).setZero();
  motion.positions_m(0, 0) = kInfinity;
  CHECK(!CheckMarkers("m", motion.names, motion.positions_m).ok());
  CHECK(!CheckFinite("m", motion.positions_m).ok());
}

TEST_CASE("Frames: names are unique and not empty", "[server][translate]") {
  CHECK(CheckUnique("names", {"A", "B"}).ok());
  CHECK(!CheckUnique("names", {"A", "B", "A"}).ok());
  CHECK(!CheckUnique("names", {"A", ""}).ok());
}

}  // namespace
}  // namespace motiondb::server
