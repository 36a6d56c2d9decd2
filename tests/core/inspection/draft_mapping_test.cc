#include "core/inspection/draft_mapping.h"

#include <catch2/catch.hpp>

#include "core/format/marker_set_file.h"

namespace motiondb::tests::draft_mapping_test {
namespace {

TEST_CASE("DraftMapping: rules of what was found, comments for the rest", "[core][inspection]") {
  core::PointCloud points;
  points.names = {"pole", "left \"knee\""};
  points.parents = {-1, 0};
  points.frames.emplace_back(Eigen::Matrix3Xd::Zero(3, 2));
  const std::string draft = core::DraftMapping(core::StandardScheme().set, points, "my rig");
  CHECK_THAT(draft, Catch::StartsWith("# A draft") && Catch::Contains("\nmapping \"my rig\"\n") &&
                        Catch::Contains("# LWrist = ?\n"));
  // Without rules it is a file in the right format that says what is missing.
  const auto read =
      core::ReadMappings({"draft", "motiondb-marker-set 1\n" + draft}, core::StandardScheme());
  CHECK_THAT(std::string(read.status().message()),
             Catch::Contains("no rule for marker") || Catch::Contains("expected a rule"));
}

}  // namespace
}  // namespace motiondb::tests::draft_mapping_test
