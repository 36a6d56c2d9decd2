#include "client/cli/motion_file.h"

#include <motiondb/v1/query.pb.h>

#include <catch2/catch.hpp>

#include "tests/client/temporary_folder.h"

namespace motiondb::tests::motion_file_test {
namespace {

using client::FindSkeletonBeside;
using client::ObservationFromFile;
using client::SkeletonFor;

TEST_CASE("MotionFile: the skeleton of an AMC is the ASF with the longest matching prefix",
          "[client][cli]") {
  const TemporaryFolder folder;
  for (const char* name : {"1.asf", "13.asf", "13_2.asf", "135.asf", "13_2.bvh", "HDM_bk.ASF"}) {
    folder.Write(name, "");
  }
  CHECK(FindSkeletonBeside(folder / "13_29.amc").value() == folder / "13_2.asf");
  CHECK(FindSkeletonBeside(folder / "13_01.amc").value() == folder / "13.asf");
  CHECK(FindSkeletonBeside(folder / "135_04.amc").value() == folder / "135.asf");
  CHECK(FindSkeletonBeside(folder / "HDM_bk_walk.amc").value() == folder / "HDM_bk.ASF");
  folder.Write("135_0.asf.gz", "");
  CHECK(FindSkeletonBeside(folder / "135_04.amc").value() == folder / "135_0.asf.gz");
  CHECK(FindSkeletonBeside(folder / "135_1.amc").value() == folder / "135.asf");
  const absl::Status none = FindSkeletonBeside(folder / "07_01.amc").status();
  CHECK(none.code() == absl::StatusCode::kNotFound);
  CHECK_THAT(std::string(none.message()),
             Catch::Contains("07_01.amc") && Catch::Contains("--skeleton"));
}

TEST_CASE("MotionFile: only AMC files need a skeleton file", "[client][cli]") {
  const TemporaryFolder folder;
  folder.Write("walk.asf", "");
  CHECK(SkeletonFor(folder / "walk.bvh", "given.asf").value().empty());
  CHECK(SkeletonFor(folder / "walk.AMC", "given.asf").value() == "given.asf");
  CHECK(SkeletonFor(folder / "walk.amc", "").value() == folder / "walk.asf");
  CHECK(SkeletonFor(folder / "robot.csv", "").value().empty());
  folder.Write("robot.urdf.gz", "");
  CHECK(SkeletonFor(folder / "robot.csv", "").value() == folder / "robot.urdf.gz");
}

TEST_CASE("MotionFile: an observation contains both files and the conventions", "[client][cli]") {
  const TemporaryFolder folder;
  folder.Write("07.asf", "bones");
  const auto amc = folder.Write("07_01.amc", std::string("frames\0\xFF", 8));
  client::SourceOptions options;
  options.up_axis = "z";
  options.metres_per_unit = 0.0254;
  const auto observation = ObservationFromFile(amc, options);
  REQUIRE(observation.ok());
  CHECK(observation->file().file_name() == "07_01.amc");
  CHECK(observation->file().data() == std::string("frames\0\xFF", 8));
  CHECK(observation->file().skeleton_file_name() == "07.asf");
  CHECK(observation->file().skeleton_data() == "bones");
  CHECK(observation->file().conventions().up_axis() == v1::UP_AXIS_Z);
  CHECK(observation->file().conventions().metres_per_unit() == 0.0254);
  CHECK(ObservationFromFile(folder / "none.bvh", {}).status().code() ==
        absl::StatusCode::kNotFound);
  CHECK(ObservationFromFile(folder.path(), {}).status().code() ==
        absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace motiondb::tests::motion_file_test
