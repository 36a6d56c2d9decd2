// Tables of points: what is written is read back unchanged, and errors of the reader.
#include <catch2/catch.hpp>
#include <limits>

#include "core/export/writers.h"
#include "core/format/readers.h"
#include "tests/core/format/reading.h"
#include "tests/core/format/some_points.h"

namespace motiondb::tests::point_table_writer_test {
namespace {

using Catch::Contains;
using core::MarkerMotion;
using core::ReadOptions;
using core::UpAxis;

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

absl::StatusOr<core::MotionFile> Read(std::string_view text, const ReadOptions& options = {}) {
  return core::ReadJointTable({.name = "walk.csv", .bytes = text}, std::nullopt, options);
}

std::string Written(const MarkerMotion& motion) {
  const auto text = core::WritePointTable(motion);
  INFO(MessageOf(text.status()));
  REQUIRE(text.ok());
  return *text;
}

constexpr std::string_view kTable =
    "time_s,a_x_m,a_y_m,a_z_m,b_x_m,b_y_m,b_z_m\n"
    "0,1,2,3,,,\n"
    "0.02,1,2,3,4,5,6\n"
    "0.04,nan,NaN,nan,4,5,6\n";

std::string With(std::string_view from, std::string_view to) {
  return Replaced(std::string(kTable), from, to);
}

}  // namespace

TEST_CASE("WritePointTable: exact text", "[core][format]") {
  MarkerMotion motion = {.names = {"Head, \"top\"", "b"}, .frame_rate_hz = 50, .positions_m = {}};
  motion.positions_m.resize(2, 6);
  motion.positions_m << 1, 2, 0.1F, kMissing, kMissing, kMissing, -0.0F, 0, 1e-7F, 1, 2, 3;
  CHECK(Written(motion) ==
        "time_s,\"Head, \"\"top\"\"_x_m\",\"Head, \"\"top\"\"_y_m\",\"Head, \"\"top\"\"_z_m\","
        "b_x_m,b_y_m,b_z_m\n"
        "0,1,2,0.1,,,\n"
        "0.02,0,0,1e-07,1,2,3\n");
}

TEST_CASE("WritePointTable: every value is read back", "[core][format]") {
  for (const float centre_m : {0.0F, 1000.0F, 1e11F}) {
    MarkerMotion motion = PointsWithGaps(
        {"a", "b c", "\xC3\x84,;\"\"", "c_x_m", "root", ";;;;;;;;;;;;;;;;"}, 500, centre_m);
    motion.positions_m.row(9).setConstant(kMissing);
    const auto file = Read(Written(motion));
    CHECK(Markers(file).names == motion.names);
    CHECK(Markers(file).frame_rate_hz == 50);
    CHECK(MaxDifference(Markers(file), motion) == 0);
    CHECK(core::Describe(file->report) == "unit 1 m (stated), z up (stated)");
  }
  const MarkerMotion one = PointsWithGaps({"a"}, 1);
  const auto file = Read(Written(one));
  CHECK(MaxDifference(Markers(file), one) == 0);
  CHECK_THAT(core::Describe(file->report), Contains("frame rate 30 Hz (assumed)"));
}

TEST_CASE("ReadJointTable: points, missing and in other units", "[core][format]") {
  const auto file = Read(kTable);
  const MarkerMotion& motion = Markers(file);
  CHECK(motion.names == std::vector<std::string>{"a", "b"});
  CHECK(motion.frame_rate_hz == 50);
  CHECK(motion.positions_m.block(0, 3, 1, 3).array().isNaN().all());
  CHECK(motion.positions_m.block(2, 0, 1, 3).array().isNaN().all());
  CHECK(motion.positions_m.row(1) == Eigen::RowVector<float, 6>(1, 2, 3, 4, 5, 6));
  const auto cm = Read("time_s,a_x_cm,a_y_cm,a_z_cm\n0,100,200,300\n1,100,200,300\n");
  CHECK(Markers(cm).positions_m(0, 2) == 3);
  const auto given = Read(
      kTable, {.metres_per_unit = 0.001, .up_axis = UpAxis::kY, .frame_rate_hz = 25, .take = {}});
  CHECK(Markers(given).frame_rate_hz == 25);
  CHECK(Markers(given).positions_m(1, 1) == Approx(-0.003));
  CHECK(Markers(given).positions_m(1, 2) == Approx(0.002));
  const auto twice = Read(With("b_x_m,b_y_m,b_z_m", "a_x_m,a_y_m,a_z_m"));
  CHECK(Markers(twice).names[1] == "a_2");
  CHECK_THAT(core::Describe(twice->report), Contains("made distinct"));
}

TEST_CASE("ReadJointTable: errors in a table of points", "[core][format]") {
  const auto error = [](std::string_view from, std::string_view to) {
    return ErrorMessageOf(Read(With(from, to)));
  };
  CHECK_THAT(error("a_x_m", "a_x"), Contains("walk.csv:1: expected column 2 to be 'NAME_x_m'"));
  CHECK_THAT(error("a_z_m,", ""),
             Contains("walk.csv:1: expected column 4 to be 'a_z_m', found 'b"));
  CHECK_THAT(error(",b_z_m", ""), Contains("expected column 7 to be 'b_z_m', found ''"));
  CHECK_THAT(error("b_x_m,b_y_m,b_z_m", "b_x_cm,b_y_cm,b_z_cm"),
             Contains("expected column 5 to be 'NAME_x_m', found 'b_x_cm'"));
  CHECK_THAT(ErrorMessageOf(Read("time_s\n0\n")), Contains("expected a column 'NAME_x_m'"));
  CHECK_THAT(ErrorMessageOf(Read("time_s,a_x_m,a_y_m,a_z_m\n")), Contains("expected a row"));
  CHECK_THAT(error("0.02,1,2,3", "0.02,1,,3"),
             Contains("walk.csv:3: expected all three coordinates of 'a' or none, found 2"));
  CHECK_THAT(error("0.02,1", "0.02,one"), Contains("walk.csv:3: expected a number in column 2"));
  CHECK_THAT(error("0.02,", ","), Contains("walk.csv:3: expected a time"));
  CHECK_THAT(error("\n0.04", "\n0.06"), Contains("walk.csv:4: expected times in steps of 0.02 s"));
  CHECK_THAT(error("0.02,1,2,3,4", "0.02,1,2,3"), Contains("walk.csv:3: expected 7 numbers"));
}

}  // namespace motiondb::tests::point_table_writer_test
