// Flags, variables and the configuration file, and their priority.
#include "server/settings/settings_reader.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <set>
#include <utility>

#include "tests/support/temporary_directory.h"

namespace motiondb::tests::settings_reader_test {
namespace {

using server::EffectiveSetting;
using server::Environment;
using server::SettingsReader;
using Task = SettingsReader::Task;

std::vector<std::string> Read(SettingsReader& reader, std::vector<std::string> arguments,
                              const Environment& environment = {}) {
  arguments.insert(arguments.begin(), "motiondbd");
  std::vector<const char*> argv;
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  std::vector<std::string> messages;
  for (const absl::Status& problem :
       reader.Read(static_cast<int>(argv.size()), argv.data(), environment)) {
    messages.emplace_back(problem.message());
  }
  return messages;
}

EffectiveSetting Find(const SettingsReader& reader, const std::string& key) {
  for (const EffectiveSetting& setting : reader.Effective()) {
    if (setting.key == key) return setting;
  }
  FAIL("no setting " + key);
  return {};
}

std::string WriteConfig(const TemporaryDirectory& directory, const std::string& text) {
  std::ofstream(directory / "motiondbd.conf") << text;
  return directory / "motiondbd.conf";
}

TEST_CASE("Settings: priority is flag, variable, file, default", "[settings]") {
  const TemporaryDirectory directory;
  const std::string file = WriteConfig(directory, "store = \"/s.db\"\nthreads = 3\n");
  struct Case {
    bool in_file, in_environment, as_flag;
    int threads;
    std::string source;
  };
  // All eight combinations of the three sources.
  for (const Case& c :
       {Case{false, false, false, 0, "default"}, Case{true, false, false, 3, file + ":2"},
        Case{false, true, false, 5, "MOTIONDBD_THREADS"},
        Case{true, true, false, 5, "MOTIONDBD_THREADS"}, Case{false, false, true, 7, "--threads"},
        Case{true, false, true, 7, "--threads"}, Case{false, true, true, 7, "--threads"},
        Case{true, true, true, 7, "--threads"}}) {
    CAPTURE(c.in_file, c.in_environment, c.as_flag);
    std::vector<std::string> arguments{"--store", "/s.db"};
    if (c.in_file) arguments.insert(arguments.end(), {"--config", file});
    if (c.as_flag) arguments.insert(arguments.end(), {"--threads", "7"});
    Environment environment;
    if (c.in_environment) environment["MOTIONDBD_THREADS"] = "5";
    SettingsReader reader;
    CHECK(Read(reader, arguments, environment).empty());
    CHECK(reader.settings().server.engine.query_threads == c.threads);
    CHECK(Find(reader, "threads").value == std::to_string(c.threads));
    CHECK(Find(reader, "threads").source == c.source);
  }
}

TEST_CASE("Settings: a time is a number", "[settings]") {
  for (const char* const text : {"nan", "inf", "-inf", "1e999", "soon"}) {
    CAPTURE(text);
    SettingsReader reader;
    CHECK(!Read(reader, {"--store", "/s.db", "--call-time-limit", text}).empty());
    SettingsReader grace;
    CHECK(!Read(grace, {"--store", "/s.db", "--grace-seconds", text}).empty());
  }
}

TEST_CASE("Settings: a count must be a whole number", "[settings]") {
  const TemporaryDirectory directory;
  for (const char* const key : {"threads", "max-frames", "failures-per-minute", "max-file-mib"}) {
    for (const char* const text : {"2.5", "many", "1e3", "7 ", ""}) {
      CAPTURE(key, text);
      const std::string message =
          std::string(key) + ": expected a whole number, got '" + text + "'";
      SettingsReader flag;
      const auto by_flag = Read(flag, {"--store", "/s.db", std::string("--") + key + "=" + text});
      SettingsReader file;
      const auto by_file =
          Read(file, {"--config", WriteConfig(directory, std::string("store = '/s.db'\n") + key +
                                                             " = '" + text + "'\n")});
      if (*text != '\0') {
        REQUIRE(by_flag.size() == 1);
        CHECK(by_flag[0] == "--" + message);
      }
      REQUIRE(by_file.size() == 1);
      CHECK(by_file[0] == directory / "motiondbd.conf" + ":2: --" + message);
    }
    for (const char* const text : {"-1", "99999999999", "99999999999999999999999"}) {
      SettingsReader reader;
      const auto problems = Read(reader, {"--store", "/s.db", std::string("--") + key, text});
      REQUIRE(problems.size() == 1);
      CHECK_THAT(problems[0], Catch::Contains(std::string("Value ") + text + " not in range"));
    }
  }
}

TEST_CASE("Settings: a number that begins with 0 is not octal", "[settings]") {
  SettingsReader reader;
  const auto problems = Read(reader, {"--store", "/s.db"}, {{"MOTIONDBD_MAX_DATABASES", "010"}});
  REQUIRE(problems.size() == 1);
  CHECK(problems[0] ==
        "MOTIONDBD_MAX_DATABASES: --max-databases: '010' begins with 0; omit the leading 0");
  SettingsReader zero;
  CHECK(Read(zero, {"--store", "/s.db", "--disk-reserve-mib", "0"}).empty());
}

TEST_CASE("Settings: a boolean is true or false; an empty variable is invalid", "[settings]") {
  for (const auto& [text, truth] : {std::pair("true", true),
                                    {"1", true},
                                    {"On", true},
                                    {"yes", true},
                                    {"false", false},
                                    {"0", false},
                                    {"off", false}}) {
    CAPTURE(text);
    SettingsReader reader;
    CHECK(Read(reader, {"--store", "/s.db"}, {{"MOTIONDBD_INSECURE", text}}).empty());
    CHECK(reader.settings().server.security.insecure == truth);
    CHECK(Find(reader, "insecure").value == (truth ? "true" : "false"));
  }
  const TemporaryDirectory directory;
  for (const char* const text : {"", "2", "-1", "truth"}) {
    CAPTURE(text);
    SettingsReader variable;
    const auto by_variable = Read(variable, {"--store", "/s.db"}, {{"MOTIONDBD_INSECURE", text}});
    REQUIRE(by_variable.size() == 1);
    CHECK(by_variable[0] == "MOTIONDBD_INSECURE: insecure: expected true or false");
    CHECK(!variable.settings().server.security.insecure);
    SettingsReader file;
    const auto by_file = Read(
        file, {"--config", WriteConfig(directory, std::string("store = '/s.db'\ninsecure = '") +
                                                      text + "'\n")});
    REQUIRE(by_file.size() == 1);
    CHECK(by_file[0] == directory / "motiondbd.conf" + ":2: insecure: expected true or false");
  }
}

TEST_CASE("Settings: HTTP and gRPC need different addresses", "[settings]") {
  const TemporaryDirectory directory;
  const auto refused = [&](const std::string& listen, const std::string& http) {
    SettingsReader reader;
    const auto read = Read(reader, {"--store", directory / "a.db", "--listen", listen,
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

TEST_CASE("Settings: every setting has a flag, a variable and a file key", "[settings]") {
  const TemporaryDirectory directory;
  SettingsReader defaults;
  CHECK(Read(defaults, {"--store", "/s.db"}).empty());
  for (const EffectiveSetting& setting : defaults.Effective()) {
    CAPTURE(setting.key);
    const std::string value = setting.key == "store" ? "\"/other.db\"" : setting.value;
    const std::string file =
        WriteConfig(directory, (setting.key == "store" ? "" : "store = '/s.db'\n") + setting.key +
                                   " = " + value);
    SettingsReader from_file;
    CHECK(Read(from_file, {"--config", file}).empty());
    CHECK(Find(from_file, setting.key).source.starts_with(file + ":"));
    CHECK(Find(from_file, setting.key).value == value);

    std::string variable = "MOTIONDBD_";
    for (const char c : setting.key) variable += c == '-' ? '_' : static_cast<char>(toupper(c));
    std::vector<absl::Status> none;
    const auto parsed = server::ParseSettings("", "k = " + value, none)[0].values;
    if (parsed.empty()) continue;  // an empty list is not written
    SettingsReader from_environment;
    Environment environment{{"MOTIONDBD_STORE", "/s.db"}};
    environment[variable] = parsed[0];
    CHECK(Read(from_environment, {}, environment).empty());
    CHECK(Find(from_environment, setting.key).source == variable);
  }
}

TEST_CASE("Settings: a flag or else a variable names the file", "[settings]") {
  const TemporaryDirectory directory;
  const std::string file = WriteConfig(directory, "store = '/from-file.db'");
  SettingsReader by_variable;
  CHECK(Read(by_variable, {}, {{"MOTIONDBD_CONFIG", file}}).empty());
  CHECK(by_variable.settings().store_path == "/from-file.db");
  SettingsReader by_flag;
  CHECK(Read(by_flag, {"--config", file}, {{"MOTIONDBD_CONFIG", "/absent"}}).empty());
  SettingsReader absent;
  const auto problems = Read(absent, {"--config", directory / "absent.conf"});
  REQUIRE(problems.size() == 2);  // the second: no store
  CHECK(problems[0].find("absent.conf: cannot be read") != std::string::npos);
}

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
  const auto problems = Read(reader, {"--config", file, "--listen", "1.2.3.4:1"},
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
      Read(reader, {"--config", file, "--store", "/s.db"}, {{"MOTIONDBD_THREADS", "many"}});
  REQUIRE(problems.size() == 2);
  CHECK_THAT(problems[0], Catch::StartsWith(file + ":2: "));
  CHECK_THAT(problems[1], Catch::StartsWith("MOTIONDBD_THREADS: "));
}

TEST_CASE("Settings: addresses are HOST:PORT", "[settings]") {
  for (const char* const good : {"127.0.0.1:50051", "[::1]:0", "localhost:65535", "0.0.0.0:1"}) {
    SettingsReader reader;
    CHECK(Read(reader, {"--store", "/s.db", "--listen", good}).empty());
    CHECK(reader.settings().server.listen == good);
  }
  for (const char* const bad :
       {"127.0.0.1", ":50051", "host:", "host:65536", "host:-1", "host:1x", "::1:50051", "[]:1"}) {
    SettingsReader reader;
    const auto problems = Read(reader, {"--store", "/s.db", "--listen", bad});
    CAPTURE(bad);
    REQUIRE(problems.size() == 1);
    CHECK(problems[0].find("HOST:PORT") != std::string::npos);
  }
}

TEST_CASE("Settings: units match the names", "[settings]") {
  SettingsReader reader;
  CHECK(Read(reader, {"--store", "/s.db", "--max-file-mib", "3", "--max-message-mib", "5",
                      "--rebuild-delay", "0.25", "--grace-seconds", "1.5"})
            .empty());
  const server::Settings& settings = reader.settings();
  CHECK(settings.server.engine.max_file_bytes == std::size_t{3} << 20);
  CHECK(settings.server.max_message_bytes == 5 << 20);
  CHECK(settings.server.engine.rebuild_delay == std::chrono::milliseconds(250));
  CHECK(settings.grace == std::chrono::milliseconds(1500));
}

TEST_CASE("Settings: one client may have a quarter of the calls, at least one", "[settings]") {
  for (const auto& [all, own] :
       {std::pair{"1", 1}, std::pair{"7", 1}, std::pair{"8", 2}, std::pair{"4000", 1000}}) {
    CAPTURE(all);
    SettingsReader reader;
    REQUIRE(Read(reader, {"--store", "/s.db", "--max-calls", all, "--max-heavy-calls", all,
                          "--max-streams", all})
                .empty());
    const server::CallLimitOptions& calls = reader.settings().server.calls;
    CHECK(calls.calls.in_all == std::stoi(all));
    CHECK(calls.calls.per_client == own);
    CHECK(calls.heavy.per_client == own);
    CHECK(calls.streams.per_client == own);
  }
  for (const char* const bad : {"0", "1.5", "-1", "1000001"}) {
    CAPTURE(bad);
    SettingsReader reader;
    CHECK(Read(reader, {"--store", "/s.db", "--max-calls", bad}).size() == 1);
  }
}

TEST_CASE("Settings: ingests delay a build by at most 10 s or the configured delay", "[settings]") {
  for (const auto& [delay, limit] :
       {std::pair{"0.5", 10}, std::pair{"10", 10}, std::pair{"20", 20}}) {
    CAPTURE(delay);
    SettingsReader reader;
    REQUIRE(Read(reader, {"--store", "/s.db", "--rebuild-delay", delay}).empty());
    CHECK(reader.settings().server.engine.rebuild_delay_limit == std::chrono::seconds(limit));
    CHECK(reader.CheckForStart().empty());
  }
}

TEST_CASE("Settings: a removed setting is ignored with a warning", "[settings]") {
  const TemporaryDirectory directory;
  const std::string file =
      WriteConfig(directory, "store = \"/s.db\"\nheavy-threads = 3\nmax-calls-per-client = 9\n");
  SettingsReader reader;
  CHECK(Read(reader, {"--config", file, "--max-metadata-kib", "16"},
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
  CHECK(settings.server.engine.heavy_threads == 0);
  CHECK(settings.server.calls.calls.per_client == 1024);
  CHECK(settings.server.calls.max_metadata_bytes == 8 << 10);
  for (const EffectiveSetting& setting : reader.Effective()) {
    CHECK(setting.key != "heavy-threads");
  }
  CHECK(reader.Help().find("per-client") == std::string::npos);
}

TEST_CASE("Settings: a time limit that would end every call is refused", "[settings]") {
  for (const char* const key : {"--call-time-limit", "--silence-limit"}) {
    CAPTURE(key);
    for (const char* const bad : {"0", "0.9", "-1"}) {
      SettingsReader reader;
      const auto problems = Read(reader, {"--store", "/s.db", key, bad});
      CAPTURE(bad);
      REQUIRE(problems.size() == 1);
      CHECK(problems[0].find(key) != std::string::npos);
      CHECK(problems[0].find("not in range 1") != std::string::npos);
    }
    SettingsReader least;
    CHECK(Read(least, {"--store", "/s.db", key, "1"}).empty());
    SettingsReader broken;
    CHECK(Read(broken, {"--store", "/s.db", key, "1.5"}).empty());
  }
  SettingsReader zero;  // where 0 is valid
  CHECK(Read(zero, {"--store", "/s.db", "--rebuild-delay", "0", "--slow-call-seconds", "0",
                    "--disk-reserve-mib", "0"})
            .empty());
  CHECK(zero.settings().disk_reserve_bytes == 0);
}

TEST_CASE("Settings: help and version need no setting", "[settings]") {
  SettingsReader help;
  CHECK(Read(help, {"--help"}, {{"MOTIONDBD_CONFIG", "/absent"}}).empty());
  CHECK(help.task() == Task::kHelp);
  CHECK(help.Help().find("--check-config") != std::string::npos);
  SettingsReader version;
  CHECK(Read(version, {"--version"}).empty());
  CHECK(version.task() == Task::kVersion);
  SettingsReader check;
  CHECK(Read(check, {"--check-config", "--store", "/s.db"}).empty());
  CHECK(check.task() == Task::kCheck);
  SettingsReader nothing;
  CHECK(Read(nothing, {}).size() == 1);
  SettingsReader unknown;
  CHECK(Read(unknown, {"--stor", "x"}).size() == 1);
}

TEST_CASE("Settings: a check examines the store's folder and changes nothing", "[settings]") {
  const TemporaryDirectory directory;
  const auto check = [&](const std::string& store) {
    SettingsReader reader;
    REQUIRE(Read(reader, {"--store", store}).empty());
    return reader.Check();
  };
  CHECK(check(directory / "new.db").empty());
  CHECK(!std::filesystem::exists(directory / "new.db"));
  REQUIRE(check(directory / "none" + "/a.db").size() == 1);
  std::filesystem::create_directory(directory / "folder");
  REQUIRE(check(directory / "folder").size() == 1);
  SettingsReader absent;
  REQUIRE(Read(absent, {"--store", directory / "new.db", "--read-only"}).empty());
  REQUIRE(absent.Check().size() == 1);  // the folder is missing
  SettingsReader memory;
  REQUIRE(Read(memory, {"--store", directory / "a.db", "--message-memory-mib", "15"}).empty());
  CHECK(memory.Check().size() == 2);  // too small for the largest request and file
  SettingsReader small_files;
  REQUIRE(Read(small_files, {"--store", directory / "a.db", "--message-memory-mib", "31",
                             "--max-file-mib", "15"})
              .empty());
  CHECK(small_files.Check().size() == 1);
}

TEST_CASE("Settings: a start and a check refuse the same, except the store", "[settings]") {
  const TemporaryDirectory directory;
  const auto refused = [&](std::vector<std::string> arguments) {
    SettingsReader reader;
    REQUIRE(Read(reader, std::move(arguments)).empty());
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

// Returns the settings of the sample file, also those commented out. Each must have a comment
// directly above.
std::map<std::string, std::string> SampleSettings() {
  std::ifstream file(MOTIONDBD_CONF);
  REQUIRE(file);
  std::map<std::string, std::string> settings;
  std::string line;
  std::string next_above;
  while (std::getline(file, line)) {
    const std::string above = std::exchange(next_above, line);
    if (line.starts_with("#")) line.erase(0, 1);
    if (line.empty() || !islower(line.front())) continue;
    std::vector<absl::Status> problems;
    const auto parsed = server::ParseSettings(MOTIONDBD_CONF, line, problems);
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
  CHECK(Read(defaults, {"--store", "/var/lib/motiondb/motion.db"}).empty());
  std::map<std::string, std::string> settings;
  for (const EffectiveSetting& setting : defaults.Effective()) {
    settings[setting.key] = setting.value;
  }
  CHECK(sample == settings);
  SettingsReader reader;
  CHECK(Read(reader, {"--config", MOTIONDBD_CONF}).empty());
}

}  // namespace
}  // namespace motiondb::tests::settings_reader_test
