// TRC text as OpenSim expects it; our own reader must read it back.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/export/writers.h"
#include "tests/core/format/reading.h"
#include "tests/core/format/some_points.h"

namespace motiondb::tests::trc_writer_test {
namespace {

using Catch::Contains;
using core::FileFormat;
using core::MarkerMotion;
using core::UpAxis;

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

std::string Written(const MarkerMotion& motion) {
  const auto text = core::WriteTrc(motion);
  INFO(MessageOf(text.status()));
  REQUIRE(text.ok());
  return *text;
}

}  // namespace

TEST_CASE("WriteTrc: exact text", "[core][format]") {
  MarkerMotion motion = {.names = {"Head", "Left\tToe "}, .frame_rate_hz = 50, .positions_m = {}};
  motion.positions_m.resize(2, 6);
  motion.positions_m << 1, 2, 1.75F, kMissing, kMissing, kMissing,  //
      0, 0, 1.5F, 0.25F, -0.5F, 0.0005F;
  CHECK(Written(motion) ==
        "PathFileType\t4\t(X/Y/Z)\tmotion.trc\n"
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\t"
        "OrigNumFrames\n"
        "50\t50\t2\t2\tmm\t50\t1\t2\n"
        "Frame#\tTime\tHead\t\t\tLeft_Toe\t\t\n"
        "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n"
        "\n"
        "1\t0\t1000\t1750\t-2000\t\t\t\n"
        "2\t0.02\t0\t1500\t0\t250\t0.500000024\t500\n");
}

TEST_CASE("WriteTrc: our reader reads it back, with gaps", "[core][format]") {
  // Without a figure in it, the reader assumes y up, as it is written.
  for (const double rate_hz : {50.0, 120.0, 60000.0 / 1001, 0.5}) {
    MarkerMotion motion = PointsWithGaps({"a", "b c", "Ä;,\"'", "#d"}, 200);
    motion.frame_rate_hz = rate_hz;
    motion.positions_m.row(7).setConstant(kMissing);
    const auto file = ReadText(FileFormat::kTrc, Written(motion));
    const MarkerMotion& read = Markers(file);
    CHECK(read.names == motion.names);
    CHECK(read.frame_rate_hz == rate_hz);
    CHECK(MaxDifference(read, motion) < 1e-5);
    CHECK(core::Describe(file->report) == "unit 0.001 m (stated), y up (assumed)");
  }
  const MarkerMotion far = PointsWithGaps({"a"}, 100, 1e5F);
  CHECK(MaxDifference(Markers(ReadText(FileFormat::kTrc, Written(far))), far) < 0.02);
}

TEST_CASE("WriteTrc: the up axis of a person is deduced, or given", "[core][format]") {
  MarkerMotion motion = {
      .names = {"Head", "LeftToe", "RightToe"}, .frame_rate_hz = 50, .positions_m = {}};
  motion.positions_m.resize(50, 9);
  motion.positions_m.rowwise() =
      Eigen::RowVector<float, 9>{0, 0, 1.7F, 0.1F, 0.1F, 0.02F, 0.1F, -0.1F, 0.02F};
  const auto standing = ReadText(FileFormat::kTrc, Written(motion));
  CHECK(MaxDifference(Markers(standing), motion) < 1e-5);
  CHECK_THAT(core::Describe(standing->report), Contains("y up (deduced)"));
  // Lying on the floor: the format cannot state the axis.
  motion.positions_m.rowwise() =
      Eigen::RowVector<float, 9>{1.7F, 0, 0.1F, 0, 0.1F, 0.1F, 0, -0.1F, 0.1F};
  const core::ReadOptions y_up = {
      .metres_per_unit = {}, .up_axis = UpAxis::kY, .frame_rate_hz = {}, .take = {}};
  CHECK(MaxDifference(Markers(ReadText(FileFormat::kTrc, Written(motion), y_up)), motion) < 1e-5);
}

TEST_CASE("WriteTrc and WritePointTable refuse invalid motion", "[core][format]") {
  const MarkerMotion good = PointsWithGaps({"a", "b"}, 3);
  const auto refusal = [](const MarkerMotion& motion) {
    const std::string trc = ErrorMessageOf(core::WriteTrc(motion));
    const std::string table = ErrorMessageOf(core::WritePointTable(motion));
    CHECK("point table" + trc.substr(std::min<std::size_t>(3, trc.size())) == table);
    return trc;
  };
  MarkerMotion bad = good;
  bad.names.clear();
  CHECK_THAT(refusal(bad), Contains("TRC: the motion has no point"));
  bad = good;
  bad.positions_m.resize(0, 6);
  CHECK_THAT(refusal(bad), Contains("no frame"));
  bad = good;
  bad.positions_m.conservativeResize(3, 5);
  CHECK_THAT(refusal(bad), Contains("expected 6 columns, three a point, found 5"));
  for (const double rate_hz : {0.0, -1.0, std::nan(""), 1e6}) {
    bad = good;
    bad.frame_rate_hz = rate_hz;
    CHECK_THAT(refusal(bad), Contains("frame rate"));
  }
  bad = good;
  bad.positions_m.row(1) << 1, 2, 3, 4, kMissing, 6;
  CHECK_THAT(refusal(bad), Contains("frame 1: expected all three coordinates of 'b' or none"));
  for (const float value : {std::numeric_limits<float>::infinity(), -2e12F}) {
    bad.positions_m.row(1) << 1, 2, 3, 4, value, 6;
    CHECK_THAT(refusal(bad), Contains("frame 1: expected coordinates of 'b' of at most 1e+12 m"));
  }
  bad = good;
  bad.names = {"a\tb", " a_b "};
  CHECK_THAT(refusal(bad), Contains("two points would be named 'a_b'"));
  bad.names = {"a", "  "};
  CHECK_THAT(refusal(bad), Contains("expected a name for point 2"));
}

}  // namespace motiondb::tests::trc_writer_test
