#include "core/format/conventions.h"

#include <array>
#include <catch2/catch.hpp>

namespace motiondb::tests::conventions_test {

using core::FileFormat;
using core::UpAxis;
using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST_CASE("WorldFromFile: a proper rotation from the up axis to z", "[core][format]") {
  const std::array<std::pair<UpAxis, Vector3d>, 6> axes = {{{UpAxis::kX, Vector3d::UnitX()},
                                                            {UpAxis::kY, Vector3d::UnitY()},
                                                            {UpAxis::kZ, Vector3d::UnitZ()},
                                                            {UpAxis::kMinusX, -Vector3d::UnitX()},
                                                            {UpAxis::kMinusY, -Vector3d::UnitY()},
                                                            {UpAxis::kMinusZ, -Vector3d::UnitZ()}}};
  for (const auto& [up, axis] : axes) {
    const Matrix3d rotation = core::WorldFromFile(up);
    CHECK(rotation * axis == Vector3d::UnitZ());
    CHECK(rotation.determinant() == 1);
    CHECK(rotation * rotation.transpose() == Matrix3d::Identity());
  }
}

TEST_CASE("DeduceConventions: heads above feet, in most frames", "[core][format]") {
  const std::vector<std::string> names = {"Anna:LFHD", "pelvis", "RANK"};
  core::FrameMatrix positions(5, 9);
  for (int frame = 0; frame < 5; ++frame) positions.row(frame) << 1, 17, 2, 0, 9, 0, 1, 1, 3;
  CHECK(core::DeduceConventions(names, positions).up_axis == UpAxis::kY);
  positions.row(1) << 17, 1, 2, 9, 0, 0, 1, 1, 3;  // lies down for some frames
  positions.row(2) = positions.row(1);
  CHECK(core::DeduceConventions(names, positions).up_axis == UpAxis::kY);
  CHECK(core::DeduceConventions(names, -positions).up_axis == UpAxis::kMinusY);
  positions.row(0).setConstant(std::numeric_limits<float>::quiet_NaN());  // not seen
  positions.row(1).setConstant(std::numeric_limits<float>::quiet_NaN());
  CHECK(core::DeduceConventions(names, positions).up_axis == UpAxis::kY);
  for (int frame = 0; frame < 5; ++frame) positions.row(frame) << 9, 9, 2, 0, 9, 0, 1, 1, 3;
  CHECK_FALSE(core::DeduceConventions(names, positions).up_axis.has_value());  // ambiguous
  CHECK_FALSE(core::DeduceConventions(std::vector<std::string>{"a", "b", "c"}, positions)
                  .up_axis.has_value());
}

TEST_CASE("SnapFrameRate: to a near customary rate, or unchanged", "[core][format]") {
  std::vector<std::string> notes;
  CHECK(core::SnapFrameRate(120.0, notes) == 120);
  CHECK(core::SnapFrameRate(0.3, notes) == 0.3);
  CHECK(core::SnapFrameRate(24.5, notes) == 24.5);
  CHECK(notes.empty());
  CHECK(core::SnapFrameRate(119.98, notes) == 120);
  CHECK(core::SnapFrameRate(119.89, notes) == Approx(120000.0 / 1001));
  CHECK(notes.size() == 2);
}

TEST_CASE("FormatOfPath: by extension, in any case", "[core][format]") {
  CHECK(*core::FormatOfPath("a/b.c/walk.bvh") == FileFormat::kBvh);
  CHECK(*core::FormatOfPath("WALK.AMC") == FileFormat::kAmc);
  CHECK(*core::FormatOfPath("walk.Trc") == FileFormat::kTrc);
  CHECK(*core::FormatOfPath(".c3d") == FileFormat::kC3d);
  CHECK(*core::FormatOfPath("a.b.vrm") == FileFormat::kGltf);
  CHECK(*core::FormatOfPath("walk.csv.GZ") == FileFormat::kCsv);
  for (const char* path : {"", "walk", "walk.txt", "walk.txt.gz", "walk.gz", ".gz", "bvh"}) {
    CHECK(core::FormatOfPath(path).status().code() == absl::StatusCode::kInvalidArgument);
  }
}

TEST_CASE("NeedsImport: by format and by compression", "[core][format]") {
  CHECK(core::NeedsImport(FileFormat::kBvh, "\x1f\x8b"));
  CHECK_FALSE(core::NeedsImport(FileFormat::kBvh, "HIERARCHY"));
  CHECK(core::NeedsImport(FileFormat::kFbx, ""));
}

}  // namespace motiondb::tests::conventions_test
