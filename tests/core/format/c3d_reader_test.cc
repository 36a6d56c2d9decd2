#include <catch2/catch.hpp>
#include <cmath>

#include "tests/core/format/c3d_builder.h"
#include "tests/core/format/reading.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::c3d_reader_test {
namespace {

using Catch::Contains;
using core::C3dProcessor;
using core::FileFormat;
using core::Provenance;
using core::ReadOptions;
using core::UpAxis;

absl::StatusOr<core::MotionFile> ReadC3d(std::string_view bytes, const ReadOptions& options = {}) {
  return ReadText(FileFormat::kC3d, bytes, options);
}

// A head and a toe in mm, z up; the toe is missing in the second frame.
C3dBuilder TwoMarkers() {
  C3dBuilder builder;
  builder.labels = {"LFHD", "LTOE"};
  builder.frames = {{{100, -200, 1700}, {50, 60, 40}},
                    {{110, -210, 1710}, {0, 0, 0, -1}},
                    {{120, -220, 1720}, {70, 80, 50}}};
  return builder;
}

}  // namespace

TEST_CASE("C3D: every processor, integer and real data", "[core][format]") {
  for (const C3dProcessor processor :
       {C3dProcessor::kIntel, C3dProcessor::kDec, C3dProcessor::kMips}) {
    for (const bool real : {true, false}) {
      C3dBuilder builder = TwoMarkers();
      builder.processor = processor;
      builder.real = real;
      builder.analog_per_frame = 3;
      CAPTURE(static_cast<int>(processor), real);
      const auto file = ReadC3d(builder.Build());
      const core::MarkerMotion& motion = Markers(file);
      CHECK(core::Describe(file->report) ==
            "unit 0.001 m (stated), z up (deduced); skipped 3 analog channels at 100 Hz");
      CHECK(motion.names == std::vector<std::string>{"LFHD", "LTOE"});
      CHECK(motion.frame_rate_hz == 100);
      REQUIRE(motion.positions_m.rows() == 3);
      CHECK(motion.positions_m(0, 0) == Approx(0.1));
      CHECK(motion.positions_m(0, 1) == Approx(-0.2));
      CHECK(motion.positions_m(2, 5) == Approx(0.05));
      CHECK(motion.positions_m.block(1, 3, 1, 3).array().isNaN().all());
    }
  }
}

TEST_CASE("C3D: missing points are invalid, not a number, or exactly at the origin",
          "[core][format]") {
  C3dBuilder builder = TwoMarkers();
  builder.frames[0][1] = {1, 2, 3, -1};
  builder.frames[1][1] = {0, 0, 0, 0};
  builder.frames[2][1] = {NAN, 2, 3, 0};
  const auto file = ReadC3d(builder.Build());
  CHECK(Markers(file).positions_m.rightCols(3).array().isNaN().all());
  builder.frames[2][1] = {INFINITY, 2, 3, 0};
  CHECK_THAT(ErrorMessageOf(ReadC3d(builder.Build())),
             Contains("walk: byte ") && Contains("finite position of 'LTOE' in frame 3"));
}

TEST_CASE("C3D: units and up axes, stated, deduced, assumed and given", "[core][format]") {
  C3dBuilder builder = TwoMarkers();
  builder.units = "cm";
  builder.y_screen = "+Y";
  const auto stated = ReadC3d(builder.Build());
  CHECK(Markers(stated).positions_m(0, 2) == Approx(-2));
  CHECK(core::Describe(stated->report) == "unit 0.01 m (stated), y up (stated)");
  builder.y_screen = "-z";
  CHECK(Markers(ReadC3d(builder.Build())).positions_m(0, 2) == Approx(-17));
  builder.units.clear();
  builder.y_screen.clear();
  CHECK(core::Describe(ReadC3d(builder.Build())->report) ==
        "unit 0.001 m (deduced), z up (deduced)");
  builder.labels = {"a", "b"};
  CHECK(core::Describe(ReadC3d(builder.Build())->report) ==
        "unit 0.001 m (assumed), z up (assumed); no figure of a person: 0.001 m per unit assumed");
  const auto given =
      ReadC3d(builder.Build(), {.metres_per_unit = 1, .up_axis = UpAxis::kX, .frame_rate_hz = 10});
  CHECK(Markers(given).positions_m(0, 2) == Approx(100));
  CHECK(Markers(given).frame_rate_hz == 10);
}

TEST_CASE("C3D: labels lose their subject, are distinct, and may continue in LABELS2",
          "[core][format]") {
  C3dBuilder builder = TwoMarkers();
  builder.labels = {"Anna:LFHD"};
  builder.labels2 = {"Anna:LTOE"};
  const auto subject = ReadC3d(builder.Build());
  CHECK(Markers(subject).names == std::vector<std::string>{"LFHD", "LTOE"});
  CHECK_THAT(core::Describe(subject->report), Contains("'Anna:' dropped from labels"));
  builder.labels2 = {"Bert:LTOE"};
  CHECK(Markers(ReadC3d(builder.Build())).names[1] == "Bert:LTOE");
  builder.labels2 = {"Anna:LFHD"};
  CHECK(Markers(ReadC3d(builder.Build())).names[1] == "LFHD_2");
  builder.labels2.clear();
  const auto unnamed = ReadC3d(builder.Build());
  CHECK(Markers(unnamed).names[1] == "point2");
  CHECK_THAT(core::Describe(unnamed->report), Contains("1 points without a label"));
}

TEST_CASE("C3D: computed points are ignored", "[core][format]") {
  C3dBuilder builder = TwoMarkers();
  builder.angles = {"LFHD"};
  const auto file = ReadC3d(builder.Build());
  CHECK(Markers(file).names == std::vector<std::string>{"LTOE"});
  CHECK(Markers(file).positions_m(0, 2) == Approx(0.04));
  CHECK_THAT(core::Describe(file->report), Contains("1 computed points"));
  builder.angles = {"LFHD", "LTOE"};
  CHECK_THAT(ErrorMessageOf(ReadC3d(builder.Build())), Contains("expected at least one marker"));
}

TEST_CASE("C3D: frames may start late and exceed 65535", "[core][format]") {
  C3dBuilder builder = TwoMarkers();
  builder.first_frame = 27;
  const auto late = ReadC3d(builder.Build());
  CHECK(Markers(late).positions_m.rows() == 3);
  CHECK_THAT(core::Describe(late->report), Contains("frames start at 27"));
  builder.first_frame = 1;
  builder.real = false;
  builder.long_count = true;
  builder.frames.resize(70000, builder.frames[0]);
  CHECK(Markers(ReadC3d(builder.Build())).positions_m.rows() == 70000);
}

TEST_CASE("C3D: long recordings have their length in TRIAL or LONG_FRAMES", "[core][format]") {
  C3dBuilder builder = TwoMarkers();
  builder.real = false;
  builder.frames.resize(70'000, builder.frames[0]);
  builder.frames[69'999][0].z = 1000;
  builder.long_frames = true;
  const auto in_point = ReadC3d(builder.Build());
  REQUIRE(Markers(in_point).positions_m.rows() == 70'000);
  CHECK(Markers(in_point).positions_m(69'999, 2) == Approx(1));
  builder.long_frames = false;
  builder.long_count = true;
  builder.first_frame = 70'001;  // more than the header can hold
  const auto in_trial = ReadC3d(builder.Build());
  REQUIRE(Markers(in_trial).positions_m.rows() == 70'000);
  CHECK_THAT(core::Describe(in_trial->report), Contains("frames start at 70001"));
}

TEST_CASE("C3D: several hundred points are named by LABELS, LABELS2 and LABELS3",
          "[core][format]") {
  C3dBuilder builder;
  for (int point = 0; point < 600; ++point) {
    builder.labels.push_back("p" + std::to_string(point));
  }
  builder.frames.emplace_back(600, C3dPoint{1, 2, 3});
  const auto file = ReadC3d(builder.Build());
  CHECK(Markers(file).names == builder.labels);
}

TEST_CASE("C3D: analog channels, force platforms and events are skipped", "[core][format]") {
  C3dBuilder builder = TwoMarkers();
  builder.labels = {"a", "b"};
  builder.y_screen = "+Z";
  const std::string without = core::Describe(ReadC3d(builder.Build())->report);
  const auto expected = Markers(ReadC3d(builder.Build()));
  builder.events = true;
  CHECK(core::Describe(ReadC3d(builder.Build())->report) == without);
  builder.analog_per_frame = 160;
  builder.analog_ratio = 10;
  builder.force_platforms = 2;
  for (const int used : {0, 16}) {  // in the header, in ANALOG
    builder.analog_used = used;
    builder.analog_ratio = used == 0 ? 10 : 0;
    const auto file = ReadC3d(builder.Build());
    CHECK_THAT(core::Describe(file->report),
               Contains("skipped 16 analog channels at 1000 Hz, 2 force platforms"));
    CHECK(Markers(file).names == expected.names);
    CHECK(Markers(file).positions_m(0, 0) == expected.positions_m(0, 0));
    CHECK(Markers(file).positions_m(2, 5) == expected.positions_m(2, 5));
  }
}

TEST_CASE("C3D: recorded analog channels and force platforms", "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  for (const char* name :
       {"sample02_pc_int.c3d", "sample02_Dec_real.c3d", "sample02_sgi_int.c3d"}) {
    CAPTURE(name);
    const auto file = ReadC3d(ReadFile(DataDir() / "formats/c3d" / name));
    CHECK(Markers(file).frame_rate_hz == 50);
    CHECK_THAT(core::Describe(file->report),
               Contains("skipped 16 analog channels at 200 Hz, 2 force platforms"));
  }
}

TEST_CASE("C3D: units in several languages", "[core][format]") {
  const std::pair<const char*, double> units[] = {{"MM", 0.001},
                                                  {"[mm]", 0.001},
                                                  {"mm.", 0.001},
                                                  {"millimeter", 0.001},
                                                  {"Millim\xE8tres", 0.001},
                                                  {"mil\xC3\xADmetros", 0.001},
                                                  {"millimetri", 0.001},
                                                  {"Cm", 0.01},
                                                  {"Zentimeter", 0.01},
                                                  {"centim\xC3\xA8tre", 0.01},
                                                  {"dm", 0.1},
                                                  {"M", 1},
                                                  {"m\xC3\xA8tres", 1},
                                                  {"metri", 1},
                                                  {"in.", 0.0254},
                                                  {"Zoll", 0.0254},
                                                  {"pouces", 0.0254},
                                                  {"feet", 0.3048}};
  C3dBuilder builder = TwoMarkers();
  for (const auto& [name, metres] : units) {
    CAPTURE(name);
    builder.units = name;
    const auto file = ReadC3d(builder.Build());
    CHECK(Markers(file).positions_m(0, 0) == Approx(100 * metres));
    CHECK(file->report.unit_provenance == Provenance::kStated);
  }
  for (const char* name : {"furlong", "miles", "mmm", "s", "?"}) {
    CAPTURE(name);
    builder.units = name;
    CHECK(core::Describe(ReadC3d(builder.Build())->report) ==
          "unit 0.001 m (deduced), z up (deduced); unknown unit '" + std::string(name) + "'");
  }
}

TEST_CASE("C3D: the header replaces an unusable scale or rate of the parameters",
          "[core][format]") {
  for (const bool real : {true, false}) {
    for (const float scale : {0.0F, NAN, INFINITY}) {
      C3dBuilder builder = TwoMarkers();
      builder.real = real;
      builder.scale_parameter = scale;
      const auto file = ReadC3d(builder.Build());
      CHECK(Markers(file).positions_m(0, 2) == Approx(1.7));
      CHECK_THAT(core::Describe(file->report),
                 Contains("POINT:SCALE is") && Contains("0.1") && Contains("of the header used"));
      builder.scale = scale;
      CHECK_THAT(ErrorMessageOf(ReadC3d(builder.Build())),
                 Contains("walk: byte 12: expected a scale that is finite and not 0, found"));
    }
  }
  C3dBuilder builder = TwoMarkers();
  builder.rate_parameter = 0.0F;
  const auto file = ReadC3d(builder.Build());
  CHECK(Markers(file).frame_rate_hz == 100);
  CHECK_THAT(core::Describe(file->report), Contains("POINT:RATE is 0: 100 of the header used"));
}

TEST_CASE("C3D: parameters may be far from the header, after the frames, or before their groups",
          "[core][format]") {
  const auto expected = Markers(ReadC3d(TwoMarkers().Build()));
  const auto check = [&](const C3dBuilder& builder) {
    const auto file = ReadC3d(builder.Build());
    CHECK(Markers(file).names == expected.names);
    CHECK(Markers(file).positions_m.row(0) == expected.positions_m.row(0));
    CHECK(Markers(file).positions_m.row(2) == expected.positions_m.row(2));
    CHECK(file->report.unit_provenance == Provenance::kStated);
  };
  C3dBuilder builder = TwoMarkers();
  builder.parameter_block = 7;
  check(builder);
  builder.groups_last = true;
  check(builder);
  builder.data_first = true;
  check(builder);
}

TEST_CASE("C3D: invalid headers are refused with their position", "[core][format]") {
  const std::string good = TwoMarkers().Build();
  REQUIRE(ReadC3d(good).ok());
  const auto with = [&good](std::size_t offset, char byte) {
    std::string bad = good;
    bad[offset] = byte;
    return ErrorMessageOf(ReadC3d(bad));
  };
  CHECK_THAT(with(0, 0), Contains("walk: byte 0: expected the parameters' block"));
  CHECK_THAT(with(0, 100), Contains("of parameters, the file has only"));
  CHECK_THAT(with(1, 0), Contains("walk: byte 1: expected the key"));
  CHECK_THAT(with(2, 3), Contains("walk: byte 2: expected 2 points, as in POINT:USED, found 3"));
  CHECK_THAT(with(9, 127), Contains("truncated"));  // the last frame
  CHECK_THAT(with(8, 0), Contains("expected at least one frame"));
  CHECK_THAT(with(16, 1), Contains("expected the data's block"));
  CHECK_THAT(with(515, 1), Contains("byte 515: expected a processor"));
  C3dBuilder builder = TwoMarkers();
  for (const float rate : {0.0F, -50.0F, NAN, INFINITY}) {
    builder.rate_hz = rate;
    CHECK_THAT(ErrorMessageOf(ReadC3d(builder.Build())), Contains("expected a frame rate"));
  }
}

TEST_CASE("C3D: any wrong byte of header and parameters is harmless", "[core][format]") {
  const std::string good = TwoMarkers().Build();
  for (std::size_t offset = 0; offset < 1024; ++offset) {
    for (const int byte : {0x00, 0x01, 0x7F, 0x80, 0xFF}) {
      std::string bad = good;
      bad[offset] = static_cast<char>(byte);
      const auto file = ReadC3d(bad);
      CHECK((file.ok() || file.status().code() == absl::StatusCode::kInvalidArgument));
    }
  }
}

TEST_CASE("C3D: every truncation is refused with a message", "[core][format]") {
  const std::string bytes = TwoMarkers().Build();
  CheckEveryTruncation(
      bytes, [](std::string_view cut) { return ReadC3d(cut); },
      [&](std::size_t length) { return length == bytes.size(); });
}

}  // namespace motiondb::tests::c3d_reader_test
