#include <catch2/catch.hpp>
#include <limits>

#include "server/engine/query/observation.h"

namespace motiondb::server::packed_frames_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST_CASE("Frames: packed floats are unpacked row by row", "[server][engine]") {
  core::FrameMatrix frames(2, 3);
  frames << 1, 2, 3, 4, 5, 6;
  const std::string bytes(reinterpret_cast<const char*>(frames.data()), 24);
  CHECK(bytes.substr(0, 4) == std::string("\x00\x00\x80\x3f", 4));  // 1.0, little-endian
  const auto back = Unpack("observation.markers", "positions", {2, bytes}, 3);
  REQUIRE(back.ok());
  CHECK(*back == frames);
}

TEST_CASE("Frames: wrong sizes are refused before memory is allocated", "[server][engine]") {
  const std::string zeros(24, '\0');
  const auto bad = Unpack("m", "positions", {2, std::string_view(zeros).substr(4)}, 3);
  CHECK(bad.status().message() == "m.positions: expected 24 bytes, 2 frames of 3 float32, got 20");
  CHECK(!Unpack("m", "positions", {0, ""}, 3).ok());
  CHECK(!Unpack("m", "positions", {-1, ""}, 3).ok());
  const int huge = std::numeric_limits<int>::max();
  CHECK(!Unpack("m", "positions", {huge, zeros}, 3 * 200).ok());
}

TEST_CASE("Frames: a marker is finite or NaN in all three coordinates", "[server][engine]") {
  const std::vector<std::string> names = {"A", "B"};
  core::FrameMatrix positions = core::FrameMatrix::Zero(2, 6);
  CHECK(CheckMarkers("m", names, positions).ok());
  positions.row(1).segment<3>(3).setConstant(kNan);
  CHECK(CheckMarkers("m", names, positions).ok());
  positions(1, 4) = 0;
  const std::string message(CheckMarkers("m", names, positions).message());
  CHECK(message.find("frame 1, marker 'B'") != std::string::npos);
  positions.row(1).setZero();
  positions(0, 0) = kInfinity;
  CHECK(!CheckMarkers("m", names, positions).ok());
  CHECK(!CheckFinite("m", positions).ok());
}

TEST_CASE("Frames: names are unique and not empty", "[server][engine]") {
  CHECK(CheckUnique("names", {"A", "B"}).ok());
  CHECK(!CheckUnique("names", {"A", "B", "A"}).ok());
  CHECK(!CheckUnique("names", {"A", ""}).ok());
}

}  // namespace
}  // namespace motiondb::server::packed_frames_test
