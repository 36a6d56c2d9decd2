// The syntax of the configuration file.
#include "server/settings/settings_file.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "tests/support/temporary_directory.h"

namespace motiondb::tests {
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

TEST_CASE("SettingsFile: strings, words, numbers and arrays, with their lines", "[settings]") {
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

TEST_CASE("SettingsFile: a byte order mark at its beginning is passed over", "[settings]") {
  const auto settings = ParseWell(
      "\xef\xbb\xbf"
      "a = 1\nb = '\xef\xbb\xbf'\n");
  REQUIRE(settings.size() == 2);
  CHECK(settings[0].key == "a");
  CHECK(settings[1].values == Values{"\xef\xbb\xbf"});
  CHECK(ParseWell("\xef\xbb\xbf").empty());
  CHECK(Problem("a = 1\n\xef\xbb\xbf") == "a.conf:2: expected `key = value`");
}

TEST_CASE("SettingsFile: a line that is no setting is named", "[settings]") {
  CHECK(Problem("a = 1\nnonsense\n") == "a.conf:2: expected `key = value`");
  CHECK(Problem("[network]\n") == "a.conf:1: expected `key = value`; there are no tables");
  CHECK(Problem("= 1") == "a.conf:1: expected `key = value`");
  CHECK(Problem("a =") == "a.conf:1: expected a value");
  CHECK(Problem("a = two words") == "a.conf:1: a: expected one value; quote one that has spaces");
  CHECK(Problem("a = \"open") == "a.conf:1: expected a closing \"");
  CHECK(Problem("a = 'open") == "a.conf:1: expected a closing '");
  CHECK(Problem("a = \"\\x\"") == "a.conf:1: expected \\\", \\\\, \\n or \\t after a backslash");
  CHECK(Problem("a = [1 2]") == "a.conf:1: expected , or ] in an array, which is on one line");
  CHECK(Problem("a = [1,") == "a.conf:1: expected a value");
  CHECK(Problem("a = 1\n\na = 2") == "a.conf:3: a: set before, in line 1");
}

TEST_CASE("SettingsFile: what is written is read back", "[settings]") {
  for (const Values& values : {Values{"0.3"}, Values{"true"}, Values{"a \"b\"\\ # c\n\t"},
                               Values{""}, Values{"127.0.0.1:0"}, Values{"inf"}}) {
    const auto read = ParseWell("k = " + server::FormatValues(values, false));
    CHECK(read[0].values == values);
  }
  const Values list{"a,b", "", "7"};
  CHECK(ParseWell("k = " + server::FormatValues(list, true))[0].values == list);
  CHECK(server::FormatValues({"0.3"}, false) == "0.3");
  CHECK(server::FormatValues({"info"}, false) == "\"info\"");
}

TEST_CASE("SettingsFile: a file that cannot be read is named", "[settings]") {
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
}  // namespace motiondb::tests
