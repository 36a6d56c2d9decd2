#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/core/format/reading.h"

namespace motiondb::tests::trc_reader_test {
namespace {

using Catch::Contains;
using core::FileFormat;
using core::Provenance;
using core::ReadOptions;
using core::UpAxis;

constexpr std::string_view kTrc =
    "PathFileType\t4\t(X/Y/Z)\twalk.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n"
    "50\t50\t3\t2\tmm\n"
    "Frame#\tTime\tHead\t\t\tLeft Toe\t\t\t\n"
    "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n"
    "\n"
    "1\t0.00\t1\t1700\t3\t4\t50\t6\n"
    "2\t0.02\t1\t1700\t3\t\t\t\n"
    "3\t0.04\tNaN\tnan\tNaN\t4\t50\t7\n";

absl::StatusOr<core::MotionFile> ReadTrc(std::string_view text, const ReadOptions& options = {}) {
  return ReadText(FileFormat::kTrc, text, options);
}

std::string Trc(std::string_view from, std::string_view to) {
  return Replaced(std::string(kTrc), from, to);
}

}  // namespace

TEST_CASE("TRC: markers in millimetres, y up, some missing", "[core][format]") {
  const auto file = ReadTrc(kTrc);
  const core::MarkerMotion& motion = Markers(file);
  CHECK(core::Describe(file->report) == "unit 0.001 m (stated), y up (deduced)");
  CHECK(motion.names == std::vector<std::string>{"Head", "Left Toe"});
  CHECK(motion.frame_rate_hz == 50);
  REQUIRE(motion.positions_m.rows() == 3);
  REQUIRE(motion.positions_m.cols() == 6);
  CHECK(motion.positions_m(0, 0) == Approx(0.001));
  CHECK(motion.positions_m(0, 1) == Approx(-0.003));
  CHECK(motion.positions_m(0, 2) == Approx(1.7));
  CHECK(motion.positions_m.block(1, 3, 1, 3).array().isNaN().all());
  CHECK(motion.positions_m.block(2, 0, 1, 3).array().isNaN().all());
  CHECK(motion.positions_m(2, 5) == Approx(0.05));
}

TEST_CASE("TRC: units and up axes, stated, deduced, assumed and given", "[core][format]") {
  CHECK(Markers(ReadTrc(Trc("\tmm", "\tcm"))).positions_m(0, 2) == Approx(17));
  CHECK(Markers(ReadTrc(Trc("\tmm", "\tm"))).positions_m(0, 2) == Approx(1700));
  CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("\tmm", "\tfurlong"))),
             Contains("walk:3: expected Units") && Contains("furlong"));
  CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("\tmm", ""))), Contains("expected Units"));
  const auto given = ReadTrc(Trc("\tmm", "\tfurlong"),
                             {.metres_per_unit = 0.01, .up_axis = UpAxis::kX, .frame_rate_hz = 10});
  CHECK(Markers(given).positions_m(0, 2) == Approx(0.01));
  CHECK(Markers(given).frame_rate_hz == 10);
  CHECK(given->report.unit_provenance == Provenance::kGiven);
  const auto unnamed = ReadTrc(Trc("Head", "A"));
  REQUIRE(unnamed.ok());
  CHECK(unnamed->report.up_axis == UpAxis::kY);
  CHECK(unnamed->report.up_provenance == Provenance::kAssumed);
  const auto z_up = ReadTrc(Trc("1\t1700\t3\t4\t50\t6", "1\t3\t1700\t4\t6\t50"));
  REQUIRE(z_up.ok());
  CHECK(z_up->report.up_axis == UpAxis::kZ);
}

TEST_CASE("TRC: line ends, trailing tabs and spaces for tabs do not matter", "[core][format]") {
  const auto same = [](const auto& file) {
    const auto expected = ReadTrc(kTrc);
    const auto& a = Markers(file).positions_m;
    const auto& b = Markers(expected).positions_m;
    return a.rows() == b.rows() && ((a.array() == b.array()) || a.array().isNaN()).all();
  };
  CHECK(same(ReadTrc(WithLineEnds(kTrc, "\r\n"))));
  CHECK(same(ReadTrc(WithLineEnds(kTrc, "\r"))));
  CHECK(same(ReadTrc(Trc("50\t6\n", "50\t6\t\t\n"))));
  CHECK(same(ReadTrc(Trc("1\t0.00\t1\t1700\t3\t4\t50\t6", " 1  0.00 1 1700 3 4 50 6 "))));
  CHECK(same(ReadTrc(Trc("\n\n1", "\n1"))));
}

TEST_CASE("TRC: names, frame numbers and times that are unusual are reported", "[core][format]") {
  const auto twice = ReadTrc(Trc("Left Toe", "Head"));
  CHECK(Markers(twice).names[1] == "Head_2");
  CHECK_THAT(core::Describe(twice->report), Contains("made distinct"));
  const auto late =
      ReadTrc(Replaced(Replaced(Trc("\n1\t0.00", "\n11\t0.00"), "\n2\t0.02", "\n12\t0.02"),
                       "\n3\t0.04", "\n13\t0.04"));
  CHECK_THAT(core::Describe(late->report), Contains("frames start at 11"));
  const auto slow = ReadTrc(Trc("3\t0.04", "3\t0.08"));
  CHECK(Markers(slow).frame_rate_hz == 50);
  CHECK_THAT(core::Describe(slow->report),
             Contains("the time column spans 0.08 s, DataRate implies 0.04 s"));
}

TEST_CASE("TRC: an invalid header is refused", "[core][format]") {
  CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("PathFileType", "File"))), Contains("walk:1: expected"));
  for (const char* rate : {"0", "-50", "nan", "", "fast"}) {
    CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("50\t50", fmt::format("{}\t50", rate)))),
               Contains("walk:3: expected a DataRate"));
  }
  for (const char* frames : {"0", "-3", "2.5", "1e30", ""}) {
    CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("\t3\t2", fmt::format("\t{}\t2", frames)))),
               Contains("walk:3: expected NumFrames"));
  }
  CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("\t3\t2", "\t3\t3"))),
             Contains("walk:4: expected 3 marker names, as in NumMarkers, found 2"));
  CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("Frame#", "Index"))), Contains("expected 'Frame#'"));
}

TEST_CASE("TRC: errors in frames name their line", "[core][format]") {
  CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("\t3\t2", "\t4\t2"))),
             Contains("truncated") && Contains("expected 4 frames, found 3"));
  CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("\t3\t2", "\t500000000\t2"))), Contains("found 3"));
  CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("\t3\t2", "\t2\t2"))),
             Contains("walk:9: expected the file to end after 2 frames"));
  CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("\n2\t", "\n5\t"))),
             Contains("walk:8: expected frame 2, found '5'"));
  CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("0.02", "0.00"))),
             Contains("walk:8: expected a time after 0 s"));
  CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("\n2\t", "\n\t"))), Contains("expected frame 2"));
  CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("0.02", ""))), Contains("expected a time in seconds"));
  CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("4\t50\t6", "4\t50"))),
             Contains("walk:7: ") && Contains("expected z of marker 'Left Toe'"));
  CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("4\t50\t6", "4\t\t6"))),
             Contains("all three coordinates of marker 'Left Toe' or none, found 2"));
  CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("4\t50\t6", "4\t5o\t6"))),
             Contains("expected y of marker 'Left Toe', found '5o'"));
  CHECK_THAT(ErrorMessageOf(ReadTrc(Trc("4\t50\t6", "4\t50\t6\t7"))),
             Contains("found '7' after them"));
}

TEST_CASE("TRC: every truncation is refused with a message", "[core][format]") {
  const std::size_t complete = kTrc.size() - 1;  // without the last line end
  CheckEveryTruncation(
      kTrc, [](std::string_view text) { return ReadTrc(text); },
      [complete](std::size_t length) { return length >= complete; });
}

}  // namespace motiondb::tests::trc_reader_test
