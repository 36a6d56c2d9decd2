// Seeds of the readers: small files of every format, mostly made with the tests' own writers.
#include <catch2/catch.hpp>
#include <string>

#include "core/format/marker_set_file.h"
#include "core/format/readers.h"
#include "core/format/writers.h"
#include "tests/core/format/c3d_builder.h"
#include "tests/core/format/odd_robot.h"
#include "tests/fuzz/seeds/seed_file.h"
#include "tests/fuzz/seeds/small_files.h"
#include "tests/support/stick_figure.h"

namespace motiondb::tests {
namespace {

TEST_CASE("Seeds: BVH", "[seeds]") {
  const std::string walk = WriteBvh({.frame_count = 3});
  WriteSeed("bvh_fuzz", "walk", walk);
  WriteSeed("bvh_fuzz", "small", kSmallBvh);
  const auto read = core::ReadBvh({"walk.bvh", walk}, {});
  REQUIRE(read.ok());
  const auto written = core::WriteBvh(std::get<core::JointMotion>(read->motion));
  REQUIRE(written.ok());
  WriteSeed("bvh_fuzz", "written", *written);
}

TEST_CASE("Seeds: ASF and AMC", "[seeds]") { WriteSeed("amc_fuzz", "small", SmallAmcWithAsf()); }

TEST_CASE("Seeds: TRC", "[seeds]") { WriteSeed("trc_fuzz", "small", kSmallTrc); }

TEST_CASE("Seeds: C3D", "[seeds]") {
  C3dBuilder builder;
  builder.labels = {"LASI", "RASI", "HEAD"};
  builder.frames.assign(2, {{100, 0, 900, 0}, {-100, 0, 900, 0}, {0, 0, 1700, -1}});
  WriteSeed("c3d_fuzz", "intel", builder.Build());
  builder.real = false;
  builder.processor = core::C3dProcessor::kDec;
  WriteSeed("c3d_fuzz", "dec", builder.Build());
  builder.processor = core::C3dProcessor::kMips;
  builder.analog_per_frame = 2;
  builder.long_count = true;
  WriteSeed("c3d_fuzz", "mips", builder.Build());
}

TEST_CASE("Seeds: URDF", "[seeds]") {
  WriteSeed("urdf_fuzz", "odd", kRobot);
  WriteSeed("urdf_fuzz", "arm", kSmallUrdf);
}

TEST_CASE("Seeds: marker sets", "[seeds]") {
  WriteSeed("marker_set_fuzz", "small", kSmallMarkerSet);
  WriteSeed("marker_set_fuzz", "standard", core::WriteMarkerSetFile(core::StandardScheme()));
}

}  // namespace
}  // namespace motiondb::tests
