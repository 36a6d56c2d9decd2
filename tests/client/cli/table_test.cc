#include "client/cli/terminal/table.h"

#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <sstream>

#include "client/cli/terminal/terminal.h"
#include "text/display_text.h"

namespace motiondb::tests::table_test {
namespace {

using namespace client;  // NOLINT: the functions under test

constexpr std::size_t kUnlimited = TerminalSize::kUnlimited;

std::vector<std::string> LinesOf(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// A table of random size with texts of very different lengths.
Table RandomTable(std::mt19937& random) {
  const auto pick = [&](int least, int most) {
    return std::uniform_int_distribution<int>(least, most)(random);
  };
  std::vector<Table::Column> columns;
  const bool has_titles = pick(0, 3) > 0;
  for (int i = pick(1, 9); i > 0; --i) {
    columns.push_back({has_titles ? "TITLE" + std::string(pick(0, 8), 'x') : "",
                       pick(0, 1) == 0 ? Align::kLeft : Align::kRight});
  }
  Table table(columns);
  for (int row = pick(0, 5); row > 0; --row) {
    std::vector<Cell> cells;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (columns[i].align == Align::kRight) {
        cells.emplace_back(pick(-9, 99'999));
        continue;
      }
      std::string text;
      for (int length = pick(0, 3) == 0 ? pick(0, 300) : pick(0, 12); length > 0; --length) {
        text += pick(0, 6) == 0 ? " " : pick(0, 6) == 0 ? "\xC3\xA4" : "a";
      }
      cells.emplace_back(text);
    }
    table.AddRow(cells);
  }
  return table;
}

TEST_CASE("Table: no line is wider than the terminal", "[client][cli]") {
  std::mt19937 random(7);
  for (int i = 0; i < 300; ++i) {
    const Table table = RandomTable(random);
    for (const std::size_t width : {40U, 60U, 80U, 200U}) {
      for (const std::string& line : LinesOf(WithStyles(table.ToString(width), false))) {
        CAPTURE(width, line);
        CHECK(DisplayWidth(line) <= width);
        CHECK(text::IsUtf8(line));
        CHECK((line.empty() || line.back() != ' '));
      }
    }
  }
}

TEST_CASE("Table: columns are aligned, also with two-byte characters", "[client][cli]") {
  Table table({{"NAME"}, {"SIZE", Align::kRight}, {"NOTE"}});
  table.AddRow({"Müller", "7", ""});
  table.AddRow({"Li", "1234", "x"});
  CHECK(WithStyles(table.ToString(kUnlimited), false) ==
        "NAME    SIZE  NOTE\n"
        "Müller     7\n"
        "Li      1234  x\n");
}

TEST_CASE("Table: leaves out empty columns, except in CSV", "[client][cli]") {
  Table table({{"NAME"}, {"SUBJECT"}, {"SIZE (m)", Align::kRight}});
  table.AddRow({"a", "", Cell(0.12345, 2)});
  table.AddRow({"b", "", Cell(std::numeric_limits<double>::quiet_NaN(), 2)});
  CHECK(WithStyles(table.ToString(kUnlimited), false) ==
        "NAME  SIZE (m)\n"
        "a         0.12\n"
        "b\n");
  CHECK(table.ToCsv() == "NAME,SUBJECT,SIZE (m)\na,,0.12345\nb,,\n");
  CHECK(table.WithFirstColumn("FILE", "x.bvh").CsvRows() == "x.bvh,a,,0.12345\nx.bvh,b,,\n");
}

TEST_CASE("Table: shortens long texts, then prints records", "[client][cli]") {
  Table table({{"ID"}, {"ERROR"}, {"DONE (%)", Align::kRight}});
  table.AddRow({"0123456789", std::string(200, 'e'), 42});
  CHECK(WithStyles(table.ToString(40), false) ==
        "ID          ERROR               DONE (%)\n"
        "0123456789  eeeeeeeeeeeeeee...        42\n");
  CHECK(WithStyles(table.ToString(30), false) ==
        "ID        0123456789\n"
        "ERROR     " +
            std::string(20, 'e') + "\n" +
            [] {
              std::string more;
              for (int i = 0; i < 9; ++i)
                more += std::string(10, ' ') + std::string(20, 'e') + "\n";
              return more;
            }() +
            "DONE (%)  42\n");
}

TEST_CASE("Table: quotes CSV; replaces control characters", "[client][cli]") {
  Table table({{"A"}, {"B"}});
  table.AddRow({"say \"hi\", you",
                "a\nb\x1b[31m\x0e"
                "1"});
  const std::string hidden = std::string(text::kReplacement);
  CHECK(table.ToCsv() ==
        "A,B\n\"say \"\"hi\"\", you\",a" + hidden + "b" + hidden + "[31m" + hidden + "1\n");
}

TEST_CASE("Wrapped: keeps the words in lines that fit", "[client][cli]") {
  CHECK(Wrapped("one two three", 9, 0) == "one two\nthree");
  CHECK(Wrapped("one two three", 11, 4) == "one two\n    three");
  CHECK(Wrapped("abcdefghij", 4, 0) == "abcd\nefgh\nij");
  CHECK(Wrapped("", 4, 0).empty());
}

TEST_CASE("WithStyles: colours only of marks, and never beyond a line", "[client][cli]") {
  const std::string text = "a " + Styled(Style::kHeading, "b") + " c\n";
  CHECK(WithStyles(text, true) == "a \x1b[1mb\x1b[0m c\n");
  CHECK(WithStyles(text, false) == "a b c\n");
  CHECK(Styled(Style::kPlain, "b") == "b");
  // Marks and other control characters in a foreign text.
  const std::string foreign =
      "x\x0e"
      "1y\nz\x1b[8m\x0e\x0e"
      "9\x0f";
  CHECK(WithStyles(foreign, true).find("\x1b[8m") == std::string::npos);
  CHECK_THAT(WithStyles(foreign, true), Catch::Contains("y\x1b[0m\nz"));
  CHECK(WithStyles(foreign, false) == text::DisplayLines(WithStyles(foreign, false)));
}

}  // namespace
}  // namespace motiondb::tests::table_test
