// The syntax of the configuration file.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "server/settings/settings_reader.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests::settings_file_test {
namespace {

using server::FileSetting;
using Values = std::vector<std::string>;

std::vector<FileSetting> ParseWell(const std::string& text) {
  std::vector<absl::Status> problems;
  std::vector<FileSetting> settings = server::ParseSettings("a.conf", text, problems);
  for (const absl::Status& problem : problems) UNSCOPED_INFO(problem);
  REQUIRE(problems.empty());
  return settings;
}

std::string Problem(const std::string& text) {
  std::vector<absl::Status> problems;
  server::ParseSettings("a.conf", text, problems);
  REQUIRE(problems.size() == 1);
  return std::string(problems[0].message());
}

TEST_CASE("SettingsFile: strings, numbers, booleans and arrays, with their lines", "[settings]") {
  const auto settings = ParseWell(
      "# a comment\n"
      "\n"
      "a = \"x # y, \\\"z\\\" \\\\ \\n\" # after\n"
      "  b='\\literal'\r\n"
      "c = 0.25#near\n"
      "d = true\n"
      "e = [ \"p q\", 'r', 3, ]\n"
      "f = []\n"
      "g = \"\"");
  REQUIRE(settings.size() == 7);
  CHECK(settings[0].key == "a");
  CHECK(settings[0].line == 3);
  CHECK(settings[0].values == Values{"x # y, \"z\" \\ \n"});
  CHECK(settings[1].values == Values{"\\literal"});
  CHECK(settings[2].values == Values{"0.25"});
  CHECK(settings[3].values == Values{"true"});
  CHECK(settings[4].values == Values{"p q", "r", "3"});
  CHECK(settings[5].values.empty());
  CHECK(settings[6].values == Values{""});
  CHECK(settings[6].line == 9);
}

TEST_CASE("SettingsFile: a byte order mark at the beginning is ignored", "[settings]") {
  const auto settings = ParseWell(
      "\xef\xbb\xbf"
      "a = 1\nb = '\xef\xbb\xbf'\n");
  REQUIRE(settings.size() == 2);
  CHECK(settings[0].key == "a");
  CHECK(settings[1].values == Values{"\xef\xbb\xbf"});
  CHECK(ParseWell("\xef\xbb\xbf").empty());
  CHECK_THAT(Problem("a = 1\n\xef\xbb\xbf"), Catch::StartsWith("a.conf:2: "));
}

TEST_CASE("SettingsFile: the error names an invalid line", "[settings]") {
  CHECK_THAT(Problem("a = 1\nnonsense\n"), Catch::StartsWith("a.conf:2: "));
  for (const char* text : {"= 1", "a =", "a = two words", "a = bare", "a = \"open", "a = 'open",
                           "a = \"\\q\"", "a = [1 2]", "a = [1,"}) {
    CAPTURE(text);
    CHECK_THAT(Problem(text), Catch::StartsWith("a.conf:1: "));
  }
  CHECK_THAT(Problem("a = 1\n\na = 2"), Catch::StartsWith("a.conf:3: "));
  CHECK(Problem("\n[network]\n") == "a.conf:2: network: expected `key = value`, got a table");
  CHECK(Problem("a.b = 1") == "a.conf:1: a: expected `key = value`, got a table");
  CHECK(Problem("a = 2026-01-01") ==
        "a.conf:1: a: expected a string, a number, true or false, or an array of these");
  CHECK(Problem("a = [[1]]") ==
        "a.conf:1: a: expected a string, a number, true or false, or an array of these");
}

TEST_CASE("SettingsFile: numbers keep their value", "[settings]") {
  CHECK(ParseWell("a = 1e3")[0].values == Values{"1000"});
  CHECK(ParseWell("a = 0x10")[0].values == Values{"16"});
  CHECK(ParseWell("a = 1_000")[0].values == Values{"1000"});
  CHECK(ParseWell("a = 0.1")[0].values == Values{"0.1"});
  CHECK(ParseWell("a = [\n1,\n'b']")[0].values == Values{"1", "b"});
}

TEST_CASE("SettingsFile: written values can be read", "[settings]") {
  for (const Values& values : {Values{"0.3"}, Values{"true"}, Values{"a \"b\"\\ # c\n\t"},
                               Values{""}, Values{"127.0.0.1:0"}, Values{"inf"}, Values{"007"},
                               Values{".5"}, Values{"1 # x"}, Values{"1\nb = 2"}}) {
    const auto read = ParseWell("k = " + server::FormatValues(values, false));
    CHECK(read[0].values == values);
  }
  const Values list{"a,b", "", "7"};
  CHECK(ParseWell("k = " + server::FormatValues(list, true))[0].values == list);
  CHECK(server::FormatValues({"0.3"}, false) == "0.3");
  CHECK(server::FormatValues({"info"}, false) == "\"info\"");
}

TEST_CASE("SettingsFile: the error names an unreadable file", "[settings]") {
  const TemporaryDirectory directory;
  const auto missing = server::ReadSettingsFile(directory / "none.conf");
  CHECK(missing.status().code() == absl::StatusCode::kNotFound);
  CHECK(std::string(missing.status().message()).find("none.conf: cannot be read") !=
        std::string::npos);
  CHECK_THAT(std::string(missing.status().message()), Catch::EndsWith("No such file or directory"));
  std::filesystem::create_directory(directory / "folder");
  CHECK_THAT(std::string(server::ReadSettingsFile(directory / "folder").status().message()),
             Catch::EndsWith("folder: cannot be read: Is a directory"));
  std::ofstream(directory / "large") << std::string((1 << 20) + 1, '#');
  CHECK(server::ReadSettingsFile(directory / "large").status().code() ==
        absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace motiondb::tests::settings_file_test
