// The text of tables: variants of CSV, times, errors and hostile files.
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "core/format/readers.h"
#include "tests/core/format/biped_table.h"
#include "tests/core/format/reading.h"

namespace motiondb::tests::csv_rows_test {
namespace {

using Catch::Contains;

std::string TableError(std::string_view from, std::string_view to) {
  return ErrorMessageOf(ReadTable(TableWith(from, to)));
}

}  // namespace

TEST_CASE("ReadJointTable: variants of CSV", "[core][format]") {
  const auto expected = ReadTable(kTable);
  const auto same = [&](std::string_view text) {
    const auto file = ReadTable(text);
    INFO(MessageOf(file.status()));
    REQUIRE(file.ok());
    return Joints(file).angles == Joints(expected).angles && Joints(file).frame_rate_hz == 50;
  };
  std::string other(kTable);
  for (const char separator : {';', '\t'}) {
    std::replace(other.begin(), other.end(), separator == ';' ? ',' : ';', separator);
    CHECK(same(other));
  }
  CHECK(same(WithLineEnds(kTable, "\r\n")));
  CHECK(same(WithLineEnds(kTable, "\r")));
  CHECK(same("\xEF\xBB\xBF" + std::string(kTable)));
  CHECK(same("# a comment, with commas\n\n" + std::string(kTable) + "\n  \n\n"));
  CHECK(same(TableWith("0.02,1,2", "\"0.02\" , 1 ,\t2")));
  CHECK(same(Replaced(WithLineEnds(kTable, ",\n"), "r_knee,", "r_knee")));
  CHECK(same(TableWith("time_s", "\"time_s\"")));
  CHECK_THAT(NotesOfTable(ReadTable(kTable.substr(0, kTable.size() - 1))), Contains("cut short"));
}

TEST_CASE("ReadJointTable: frame rate of the times", "[core][format]") {
  const auto times = [](std::string_view second, std::string_view third) {
    return ReadTable(Replaced(TableWith("\n0.02", fmt::format("\n{}", second)), "\n0.04",
                              fmt::format("\n{}", third)));
  };
  CHECK(Joints(times("0.033", "0.067")).frame_rate_hz == Approx(30).epsilon(0.01));
  CHECK(Joints(times("0.02", "0.0401")).frame_rate_hz == Approx(50).epsilon(0.01));
  CHECK_THAT(ErrorMessageOf(times("0.02", "0.06")),
             Contains("walk.csv:4: expected times in steps of") && Contains("found 0.06 s after"));
  CHECK_THAT(ErrorMessageOf(times("0", "0.04")), Contains("walk.csv:3: expected times that inc"));
  CHECK_THAT(ErrorMessageOf(times("1e-7", "2e-7")), Contains("frame rate"));
  CHECK(Joints(ReadTable(TableWith("\n0.04", "\n9"), kBiped,
                         {.metres_per_unit = {}, .up_axis = {}, .frame_rate_hz = 10, .take = {}}))
            .frame_rate_hz == 10);
}

TEST_CASE("ReadJointTable: errors name line, column and joints", "[core][format]") {
  CHECK_THAT(ErrorMessageOf(core::ReadJointTable({.name = "walk.csv", .bytes = kTable}, {}, {})),
             Contains("walk.csv:1: expected the robot's URDF (--skeleton FILE.urdf)"));
  CHECK_THAT(ErrorMessageOf(ReadTable("")), Contains("walk.csv:1: the file is empty, expected"));
  CHECK_THAT(ErrorMessageOf(ReadTable("a,b\n1,2\n")),
             Contains("walk.csv:1: expected a table of joints"));
  CHECK_THAT(ErrorMessageOf(ReadTable(kTable, "<robot/>")), Contains("robot.urdf"));
  CHECK_THAT(TableError("l_hip,l_knee", "left,l_knee"),
             Contains("walk.csv:1: expected a column for each joint of the URDF, found no column "
                      "for 'l_hip', and 'left', not joints of the URDF"));
  CHECK_THAT(TableError("l_hip,l_knee", "l_hip,l_hip"), Contains("found 'l_hip' twice"));
  CHECK_THAT(TableError("l_hip,l_knee", "l_hip,l_hip_rad"), Contains("one column for each joint"));
  CHECK_THAT(TableError("root_z_m,", "z,"), Contains("walk.csv:1: expected columns root_x_m"));
  CHECK_THAT(TableError("root_qz,", "z,"), Contains("walk.csv:1: expected columns root_qx"));
  CHECK_THAT(TableError("time_s", "Frame"), Contains("walk.csv:1: expected a column time_s"));
  CHECK_THAT(TableError("\n0.02,1,2", "\n# x\n0.02,1,x"),
             Contains("walk.csv:4: expected a number in column 3 ('root_y_m'), found 'x'"));
  CHECK_THAT(TableError("0.02,1,2", "0.02,1,"),
             Contains("walk.csv:3: ") && Contains("an empty cell"));
  CHECK_THAT(TableError("0.02,1,2", "0.02,1,nan"), Contains("found 'nan'"));
  CHECK_THAT(TableError("0.02,1,2", "0.02,1"),
             Contains("walk.csv:3: expected 12 numbers, found 11"));
  CHECK_THAT(TableError("0,0,0.6,0.8", "0,0,0,0.4"),
             Contains("walk.csv:4: expected a quaternion of the root with norm 1, found norm 0.4"));
  CHECK_THAT(TableError("0,0,0.6,0.8", "0,0,2,2"),
             Contains("walk.csv:4: ") && Contains("norm 2.8"));
  CHECK_THAT(NotesOfTable(ReadTable(TableWith("0,0,0.6,0.8", "0,0,0.66,0.88"))),
             Contains("from 1 by up to 0.1"));
  CHECK_THAT(TableError("0.02,1", "\"0.02,1"), Contains("walk.csv:3: expected a closing quote"));
  CHECK_THAT(TableError("0.02,1", "\"0.02\"x,1"),
             Contains("walk.csv:3: ") && Contains("found 'x,1"));
  CHECK_THAT(ErrorMessageOf(ReadTable("1,2,3\n")), Contains("walk.csv:1: expected 11 numbers"));
}

TEST_CASE("ReadJointTable: a truncated file is refused, or has whole lines",
          "[core][format][hostile]") {
  CheckEveryTruncation(
      kTable, [](const std::string& cut) { return ReadTable(cut); },
      [&](std::size_t length) {
        // A line has all cells if the last one, "0.4", has at least its first digit.
        const std::string_view rest = kTable.substr(std::min(length, kTable.size()));
        const bool last_cell = rest.empty() || rest == "\n" || rest == ".4\n" || rest == "4\n" ||
                               rest.starts_with("\n0.0") || rest.starts_with(".4\n0.0") ||
                               rest.starts_with("4\n0.0") || rest.starts_with("0.02") ||
                               rest.starts_with("0.04");
        return last_cell && length > kTable.find("\n0,1");
      });
}

TEST_CASE("ReadJointTable: sizes in a file do not allocate", "[core][format][hostile]") {
  const std::string wide(1'000'000, ',');
  CHECK_THAT(ErrorMessageOf(ReadTable("1" + wide)), Contains("expected at most 196606 cells"));
  CHECK_THAT(ErrorMessageOf(ReadTable("time_s,a_x_m\n" + wide)), Contains("expected"));
  std::string narrow = std::string(100'000, ',') + "\n";
  narrow.append(1'000'000, '\n');
  CHECK_THAT(ErrorMessageOf(ReadTable("1" + narrow)), Contains("expected 11 numbers"));
  CHECK_THAT(ErrorMessageOf(ReadTable("\"" + std::string(1'000'000, 'a'))),
             Contains("closing quote"));
  CHECK_THAT(ErrorMessageOf(ReadTable("\"" + std::string(999'999, '"'))), Contains("expected"));
  const auto bytes = core::MaxBytesToReadJointTable({.name = "walk.csv", .bytes = kTable}, {});
  CHECK(bytes > 16 * 4 * 12);
  CHECK(bytes < 100 * static_cast<std::int64_t>(kTable.size()));
}

}  // namespace motiondb::tests::csv_rows_test
