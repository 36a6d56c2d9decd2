// Problems are reported together, each with its place. Also the checks before a start, and the
// sample configuration file.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "server/settings/settings_reader.h"
#include "tests/server/settings/settings_fixture.h"
#include "tests/support/project_paths.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests::settings_check_test {
namespace {

using server::EffectiveSetting;
using server::SettingsReader;
using Task = SettingsReader::Task;

TEST_CASE("Settings: all mistakes are reported, each with its place", "[settings]") {
  const TemporaryDirectory directory;
  const std::string file = WriteConfig(directory,
                                       "store = '/s.db'\n"
                                       "thread = 3\n"
                                       "threads = -3\n"
                                       "max-frames = 'many'\n"
                                       "\n"
                                       "listen = [ 'a:1', 'b:1' ]\n"
                                       "config = 'x'\n"
                                       "rebuild-delay = 0.5\n");
  SettingsReader reader;
  const auto problems = ReadSettings(reader, {"--config", file, "--listen", "1.2.3.4:1"},
                                     {{"MOTIONDBD_LOG_LEVEL", "loud"}, {"MOTIONDBD_THRAEDS", "1"}});
  REQUIRE(problems.size() == 7);
  const auto names = [&](const std::string& place, const std::string& what) {
    for (const std::string& problem : problems) {
      if (problem.starts_with(place + ": ") && problem.find(what) != std::string::npos) return true;
    }
    return false;
  };
  for (const std::string& problem : problems) UNSCOPED_INFO(problem);
  CHECK(names(file + ":2", "unknown setting: thread"));
  CHECK(names(file + ":3", "--threads"));
  CHECK(names(file + ":4", "many"));
  CHECK(names(file + ":6", "listen: expected one value"));
  CHECK(names(file + ":7", "unknown setting: config"));
  CHECK(names("MOTIONDBD_LOG_LEVEL", "loud"));
  CHECK(names("MOTIONDBD_THRAEDS", "unknown setting"));
}

TEST_CASE("Settings: a file that is not TOML is reported with other mistakes", "[settings]") {
  const TemporaryDirectory directory;
  const std::string file = WriteConfig(directory, "threads = 2\nlog-level = info\n");
  SettingsReader reader;
  const auto problems =
      ReadSettings(reader, {"--config", file, "--store", "/s.db"}, {{"MOTIONDBD_THREADS", "many"}});
  REQUIRE(problems.size() == 2);
  CHECK_THAT(problems[0], Catch::StartsWith(file + ":2: "));
  CHECK_THAT(problems[1], Catch::StartsWith("MOTIONDBD_THREADS: "));
}

TEST_CASE("Settings: a removed setting is ignored with a warning", "[settings]") {
  const TemporaryDirectory directory;
  const std::string file =
      WriteConfig(directory, "store = \"/s.db\"\nheavy-threads = 3\nmax-calls-per-client = 9\n");
  SettingsReader reader;
  CHECK(ReadSettings(reader, {"--config", file, "--max-metadata-kib", "16"},
                     {{"MOTIONDBD_REBUILD_DELAY_LIMIT", "5"}})
            .empty());
  const std::vector<std::string>& warnings = reader.warnings();
  REQUIRE(warnings.size() == 4);
  CHECK(warnings[0] == file +
                           ":2: heavy-threads was removed and is ignored: long work uses all "
                           "threads but one (see threads)");
  CHECK(warnings[1].starts_with(file + ":3: max-calls-per-client was removed and is ignored"));
  CHECK(warnings[2].starts_with("MOTIONDBD_REBUILD_DELAY_LIMIT: rebuild-delay-limit was removed"));
  CHECK(warnings[3].starts_with("--max-metadata-kib: max-metadata-kib was removed and is"));
  const server::Settings& settings = reader.settings();
  CHECK(settings.server.calls.calls.per_client == 1024);
  CHECK(settings.server.calls.max_metadata_bytes == 8 << 10);
  for (const EffectiveSetting& setting : reader.Effective()) {
    CHECK(setting.key != "heavy-threads");
  }
  CHECK(reader.Help().find("per-client") == std::string::npos);
}

TEST_CASE("Settings: help and version need no setting", "[settings]") {
  SettingsReader help;
  CHECK(ReadSettings(help, {"--help"}, {{"MOTIONDBD_CONFIG", "/absent"}}).empty());
  CHECK(help.task() == Task::kHelp);
  CHECK(help.Help().find("--check-config") != std::string::npos);
  SettingsReader version;
  CHECK(ReadSettings(version, {"--version"}).empty());
  CHECK(version.task() == Task::kVersion);
  SettingsReader check;
  CHECK(ReadSettings(check, {"--check-config", "--store", "/s.db"}).empty());
  CHECK(check.task() == Task::kCheck);
  SettingsReader nothing;
  CHECK(ReadSettings(nothing, {}).size() == 1);
  SettingsReader unknown;
  CHECK(ReadSettings(unknown, {"--stor", "x"}).size() == 1);
}

TEST_CASE("Settings: a check examines the store's folder and changes nothing", "[settings]") {
  const TemporaryDirectory directory;
  const auto check = [&](const std::string& store) {
    SettingsReader reader;
    REQUIRE(ReadSettings(reader, {"--store", store}).empty());
    return reader.Check();
  };
  CHECK(check(directory / "new.db").empty());
  CHECK(!std::filesystem::exists(directory / "new.db"));
  REQUIRE(check(directory / "none" + "/a.db").size() == 1);
  std::filesystem::create_directory(directory / "folder");
  REQUIRE(check(directory / "folder").size() == 1);
  SettingsReader absent;
  REQUIRE(ReadSettings(absent, {"--store", directory / "new.db", "--read-only"}).empty());
  REQUIRE(absent.Check().size() == 1);  // the folder is missing
  SettingsReader memory;
  REQUIRE(
      ReadSettings(memory, {"--store", directory / "a.db", "--message-memory-mib", "15"}).empty());
  CHECK(memory.Check().size() == 2);  // too small for the largest request and file
  SettingsReader small_files;
  REQUIRE(ReadSettings(small_files, {"--store", directory / "a.db", "--message-memory-mib", "31",
                                     "--max-file-mib", "15"})
              .empty());
  CHECK(small_files.Check().size() == 1);
}

TEST_CASE("Settings: a start and a check refuse the same, except the store", "[settings]") {
  const TemporaryDirectory directory;
  const auto refused = [&](std::vector<std::string> arguments) {
    SettingsReader reader;
    REQUIRE(ReadSettings(reader, std::move(arguments)).empty());
    std::vector<std::string> messages;
    for (const absl::Status& problem : reader.CheckForStart()) {
      messages.emplace_back(problem.message());
    }
    return messages;
  };
  const std::string store = directory / "a.db";
  CHECK(refused({"--store", store}).empty());
  CHECK(
      refused({"--store", directory / "none" + "/a.db"}).empty());  // opening the store reports it
  const auto both = refused({"--store", store, "--message-memory-mib", "31", "--max-file-mib", "15",
                             "--listen", "0.0.0.0:50051"});
  REQUIRE(both.size() == 2);
  CHECK(both[0].find("message-memory-mib") != std::string::npos);
  CHECK(both[1].find("without TLS") != std::string::npos);
  const auto file =
      refused({"--store", store, "--tls-certificate", "/absent.crt", "--tls-key", "/absent.key"});
  REQUIRE(file.size() == 1);
  CHECK(file[0].find("/absent.crt") != std::string::npos);
}

TEST_CASE("Settings: HTTP and gRPC need different addresses", "[settings]") {
  const TemporaryDirectory directory;
  const auto refused = [&](const std::string& listen, const std::string& http) {
    SettingsReader reader;
    const auto read = ReadSettings(reader, {"--store", directory / "a.db", "--listen", listen,
                                            "--http-listen", http, "--insecure"});
    REQUIRE(read.empty());
    const auto problems = reader.CheckForStart();
    if (problems.empty()) return false;
    REQUIRE(problems.size() == 1);
    CHECK_THAT(std::string(problems[0].message()),
               Catch::StartsWith("listen and http-listen: ") && Catch::Contains(listen));
    return true;
  };
  CHECK(refused("127.0.0.1:50051", "127.0.0.1:50051"));
  CHECK(refused("0.0.0.0:7", "127.0.0.1:7"));
  CHECK(refused("127.0.0.1:7", "[::]:7"));
  CHECK(refused("localhost:7", "127.0.0.1:7"));
  CHECK(refused("127.0.0.1:9464", ""));  // default address of HTTP
  CHECK(!refused("127.0.0.1:9464", "none"));
  CHECK(!refused("127.0.0.1:9464", "127.0.0.1:9465"));
  CHECK(!refused("127.0.0.1:0", "127.0.0.1:0"));  // two free ports
  CHECK(!refused("127.0.0.1:7", "127.0.0.2:7"));
  CHECK(!refused("127.0.0.1:50051", ""));
}

TEST_CASE("Settings: the HTTP API needs its own address", "[settings]") {
  const TemporaryDirectory directory;
  const auto problems = [&](const std::string& web, const std::string& http) {
    SettingsReader reader;
    REQUIRE(ReadSettings(reader, {"--store", directory / "a.db", "--listen", "127.0.0.1:7",
                                  "--web-listen", web, "--http-listen", http})
                .empty());
    std::string messages;
    for (const absl::Status& problem : reader.CheckForStart()) {
      messages += std::string(problem.message()) + "\n";
    }
    return messages;
  };
  CHECK(problems("none", "none").empty());
  CHECK(problems("127.0.0.1:8", "127.0.0.1:9").empty());
  CHECK_THAT(problems("127.0.0.1:7", "none"), Catch::StartsWith("listen and web-listen: "));
  CHECK_THAT(problems("127.0.0.1:9464", ""), Catch::StartsWith("web-listen and http-listen: "));
  CHECK_THAT(problems("0.0.0.0:8", "none"), Catch::Contains("0.0.0.0:8 is reachable"));
}

std::string SampleFile() { return SourcePath("deploy/motiondbd.conf"); }

// Returns the settings of the sample file, also those commented out. Each must have a comment
// directly above.
std::map<std::string, std::string> SampleSettings() {
  std::ifstream file(SampleFile());
  REQUIRE(file);
  std::map<std::string, std::string> settings;
  std::string line;
  std::string next_above;
  while (std::getline(file, line)) {
    const std::string above = std::exchange(next_above, line);
    if (line.starts_with("#")) line.erase(0, 1);
    if (line.empty() || !islower(line.front())) continue;
    std::vector<absl::Status> problems;
    const auto parsed = server::ParseSettings(SampleFile(), line, problems);
    INFO(line);
    CHECK(above.starts_with("# "));
    REQUIRE(problems.empty());
    REQUIRE(parsed.size() == 1);
    const std::size_t equals = line.find('=');
    const bool is_array = line.find('[', equals) == equals + 2;
    CHECK(settings.emplace(parsed[0].key, server::FormatValues(parsed[0].values, is_array)).second);
  }
  return settings;
}

TEST_CASE("Settings: the sample has every setting, with its default", "[settings]") {
  const std::map<std::string, std::string> sample = SampleSettings();
  SettingsReader defaults;
  CHECK(ReadSettings(defaults, {"--store", "/var/lib/motiondb/motion.db"}).empty());
  std::map<std::string, std::string> settings;
  for (const EffectiveSetting& setting : defaults.Effective()) {
    settings[setting.key] = setting.value;
  }
  CHECK(sample == settings);
  SettingsReader reader;
  CHECK(ReadSettings(reader, {"--config", SampleFile()}).empty());
}

}  // namespace
}  // namespace motiondb::tests::settings_check_test
