// The values of settings: their sources and priority, types, ranges and units.
#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "server/settings/settings_reader.h"
#include "tests/server/settings/settings_fixture.h"
#include "tests/support/certificates.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests::setting_values_test {
namespace {

using server::EffectiveSetting;
using server::Environment;
using server::SettingsReader;

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
    CHECK(ReadSettings(reader, arguments, environment).empty());
    CHECK(reader.settings().server.engine.query_threads == c.threads);
    CHECK(FindSetting(reader, "threads").value == std::to_string(c.threads));
    CHECK(FindSetting(reader, "threads").source == c.source);
  }
}

TEST_CASE("Settings: every setting has a flag, a variable and a file key", "[settings]") {
  const TemporaryDirectory directory;
  SettingsReader defaults;
  CHECK(ReadSettings(defaults, {"--store", "/s.db"}).empty());
  for (const EffectiveSetting& setting : defaults.Effective()) {
    CAPTURE(setting.key);
    const std::string value = setting.key == "store" ? "\"/other.db\"" : setting.value;
    const std::string file =
        WriteConfig(directory, (setting.key == "store" ? "" : "store = '/s.db'\n") + setting.key +
                                   " = " + value);
    SettingsReader from_file;
    CHECK(ReadSettings(from_file, {"--config", file}).empty());
    CHECK(FindSetting(from_file, setting.key).source.starts_with(file + ":"));
    CHECK(FindSetting(from_file, setting.key).value == value);

    std::string variable = "MOTIONDBD_";
    for (const char c : setting.key) variable += c == '-' ? '_' : static_cast<char>(toupper(c));
    std::vector<absl::Status> none;
    const auto parsed = server::ParseSettings("", "k = " + value, none)[0].values;
    if (parsed.empty()) continue;  // an empty list is not written
    SettingsReader from_environment;
    Environment environment{{"MOTIONDBD_STORE", "/s.db"}};
    environment[variable] = parsed[0];
    CHECK(ReadSettings(from_environment, {}, environment).empty());
    CHECK(FindSetting(from_environment, setting.key).source == variable);
  }
}

TEST_CASE("Settings: a flag or else a variable names the file", "[settings]") {
  const TemporaryDirectory directory;
  const std::string file = WriteConfig(directory, "store = '/from-file.db'");
  SettingsReader by_variable;
  CHECK(ReadSettings(by_variable, {}, {{"MOTIONDBD_CONFIG", file}}).empty());
  CHECK(by_variable.settings().store_path == "/from-file.db");
  SettingsReader by_flag;
  CHECK(ReadSettings(by_flag, {"--config", file}, {{"MOTIONDBD_CONFIG", "/absent"}}).empty());
  SettingsReader absent;
  const auto problems = ReadSettings(absent, {"--config", directory / "absent.conf"});
  REQUIRE(problems.size() == 2);  // the second: no store
  CHECK(problems[0].find("absent.conf: cannot be read") != std::string::npos);
}

TEST_CASE("Settings: a time is a number", "[settings]") {
  for (const char* const text : {"nan", "inf", "-inf", "1e999", "soon"}) {
    CAPTURE(text);
    SettingsReader reader;
    CHECK(!ReadSettings(reader, {"--store", "/s.db", "--call-time-limit", text}).empty());
    SettingsReader grace;
    CHECK(!ReadSettings(grace, {"--store", "/s.db", "--grace-seconds", text}).empty());
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
      const auto by_flag =
          ReadSettings(flag, {"--store", "/s.db", std::string("--") + key + "=" + text});
      SettingsReader file;
      const auto by_file =
          ReadSettings(file, {"--config", WriteConfig(directory, std::string("store = '/s.db'\n") +
                                                                     key + " = '" + text + "'\n")});
      if (*text != '\0') {
        REQUIRE(by_flag.size() == 1);
        CHECK(by_flag[0] == "--" + message);
      }
      REQUIRE(by_file.size() == 1);
      CHECK(by_file[0] == directory / "motiondbd.conf" + ":2: --" + message);
    }
    for (const char* const text : {"-1", "99999999999", "99999999999999999999999"}) {
      SettingsReader reader;
      const auto problems =
          ReadSettings(reader, {"--store", "/s.db", std::string("--") + key, text});
      REQUIRE(problems.size() == 1);
      CHECK_THAT(problems[0], Catch::Contains(std::string("Value ") + text + " not in range"));
    }
  }
}

TEST_CASE("Settings: a number that begins with 0 is not octal", "[settings]") {
  SettingsReader reader;
  const auto problems =
      ReadSettings(reader, {"--store", "/s.db"}, {{"MOTIONDBD_MAX_DATABASES", "010"}});
  REQUIRE(problems.size() == 1);
  CHECK(problems[0] ==
        "MOTIONDBD_MAX_DATABASES: --max-databases: '010' begins with 0; omit the leading 0");
  SettingsReader zero;
  CHECK(ReadSettings(zero, {"--store", "/s.db", "--disk-reserve-mib", "0"}).empty());
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
    CHECK(ReadSettings(reader, {"--store", "/s.db"}, {{"MOTIONDBD_INSECURE", text}}).empty());
    CHECK(reader.settings().server.security.insecure == truth);
    CHECK(FindSetting(reader, "insecure").value == (truth ? "true" : "false"));
  }
  const TemporaryDirectory directory;
  for (const char* const text : {"", "2", "-1", "truth"}) {
    CAPTURE(text);
    SettingsReader variable;
    const auto by_variable =
        ReadSettings(variable, {"--store", "/s.db"}, {{"MOTIONDBD_INSECURE", text}});
    REQUIRE(by_variable.size() == 1);
    CHECK(by_variable[0] == "MOTIONDBD_INSECURE: insecure: expected true or false");
    CHECK(!variable.settings().server.security.insecure);
    SettingsReader file;
    const auto by_file = ReadSettings(
        file, {"--config", WriteConfig(directory, std::string("store = '/s.db'\ninsecure = '") +
                                                      text + "'\n")});
    REQUIRE(by_file.size() == 1);
    CHECK(by_file[0] == directory / "motiondbd.conf" + ":2: insecure: expected true or false");
  }
}

TEST_CASE("Settings: a time limit that would end every call is refused", "[settings]") {
  for (const char* const key : {"--call-time-limit", "--silence-limit"}) {
    CAPTURE(key);
    for (const char* const bad : {"0", "0.9", "-1"}) {
      SettingsReader reader;
      const auto problems = ReadSettings(reader, {"--store", "/s.db", key, bad});
      CAPTURE(bad);
      REQUIRE(problems.size() == 1);
      CHECK(problems[0].find(key) != std::string::npos);
      CHECK(problems[0].find("not in range 1") != std::string::npos);
    }
    SettingsReader least;
    CHECK(ReadSettings(least, {"--store", "/s.db", key, "1"}).empty());
    SettingsReader broken;
    CHECK(ReadSettings(broken, {"--store", "/s.db", key, "1.5"}).empty());
  }
  SettingsReader zero;  // where 0 is valid
  CHECK(ReadSettings(zero, {"--store", "/s.db", "--rebuild-delay", "0", "--slow-call-seconds", "0",
                            "--disk-reserve-mib", "0"})
            .empty());
  CHECK(zero.settings().disk_reserve_bytes == 0);
}

TEST_CASE("Settings: addresses are HOST:PORT", "[settings]") {
  for (const char* const good : {"127.0.0.1:50051", "[::1]:0", "localhost:65535", "0.0.0.0:1"}) {
    SettingsReader reader;
    CHECK(ReadSettings(reader, {"--store", "/s.db", "--listen", good}).empty());
    CHECK(reader.settings().server.listen == good);
  }
  for (const char* const bad :
       {"127.0.0.1", ":50051", "host:", "host:65536", "host:-1", "host:1x", "::1:50051", "[]:1"}) {
    SettingsReader reader;
    const auto problems = ReadSettings(reader, {"--store", "/s.db", "--listen", bad});
    CAPTURE(bad);
    REQUIRE(problems.size() == 1);
    CHECK(problems[0].find("HOST:PORT") != std::string::npos);
  }
}

TEST_CASE("Settings: other servers reach the advertised address", "[settings]") {
  for (const char* const good :
       {"", "10.0.0.2:50051", "[fd00::1]:1", "robot-1.example.org:65535"}) {
    SettingsReader reader;
    CHECK(ReadSettings(reader, {"--store", "/s.db", "--advertise", good}).empty());
    CHECK(reader.settings().server.advertise == good);
  }
  for (const char* const bad : {"10.0.0.2", "10.0.0.2:0", "0.0.0.0:50051", "[::]:1", "a b", ":1"}) {
    SettingsReader reader;
    CAPTURE(bad);
    const auto problems = ReadSettings(reader, {"--store", "/s.db", "--advertise", bad});
    REQUIRE(problems.size() == 1);
    CHECK_THAT(problems[0], Catch::Contains("advertise") && Catch::Contains(bad));
  }
}

TEST_CASE("Settings: units match the names", "[settings]") {
  SettingsReader reader;
  CHECK(ReadSettings(reader, {"--store", "/s.db", "--max-file-mib", "3", "--max-message-mib", "5",
                              "--rebuild-delay", "0.25", "--grace-seconds", "1.5"})
            .empty());
  const server::Settings& settings = reader.settings();
  CHECK(settings.server.engine.max_file_bytes == std::size_t{3} << 20);
  CHECK(settings.server.max_message_bytes == 5 << 20);
  CHECK(settings.server.engine.rebuild_delay == std::chrono::milliseconds(250));
  CHECK(settings.grace == std::chrono::milliseconds(1500));
}

TEST_CASE("Settings: a message has room for a block of a file", "[settings]") {
  SettingsReader reader;
  CHECK(ReadSettings(reader, {"--store", "/s.db", "--max-message-mib", "2"}).empty());
  SettingsReader small;
  const auto problems = ReadSettings(small, {"--store", "/s.db", "--max-message-mib", "1"});
  REQUIRE(problems.size() == 1);
  CHECK_THAT(problems[0], Catch::Contains("max-message-mib") && Catch::Contains("2 to 1024"));
}

TEST_CASE("Settings: servers of one store share the work, a server of a file does all",
          "[settings]") {
  SettingsReader both;
  CHECK(ReadSettings(both, {"--store", "postgresql://h/d", "--model-memory", "3"}).empty());
  CHECK(both.settings().server.engine.work == server::ServerWork::kBoth);
  CHECK(both.settings().server.engine.model_memory_bytes == std::int64_t{3} << 20);
  SettingsReader serve;
  CHECK(ReadSettings(serve, {"--store", "postgresql://h/d", "--work", "serve"}).empty());
  CHECK(serve.settings().server.engine.work == server::ServerWork::kServe);
  CHECK_FALSE(serve.settings().server.engine.builds());
  SettingsReader file;
  REQUIRE(ReadSettings(file, {"--store", "/s.db", "--work", "build"}).empty());
  const auto problems = file.CheckForStart();
  REQUIRE(problems.size() == 1);
  CHECK_THAT(std::string(problems[0].message()), Catch::Contains("work: expected both"));
}

TEST_CASE("Settings: certificates of other servers need a store that servers share", "[settings]") {
  const TemporaryDirectory directory;
  const Authority authority(directory / "", "authority");
  const KeyPairFiles pair = authority.Issue("server", "motiondb");
  const auto problems = [&](const std::string& store, const std::string& option) {
    SettingsReader reader;
    REQUIRE(ReadSettings(reader, {"--store", store, "--tls-certificate", pair.certificate,
                                  "--tls-key", pair.key, option, authority.certificate()})
                .empty());
    std::string messages;
    for (const absl::Status& problem : reader.CheckForStart()) {
      messages += std::string(problem.message());
    }
    return messages;
  };
  for (const std::string name : {"tls-peer-ca", "tls-peer-name"}) {
    CHECK(problems("postgresql://h/d", "--" + name).empty());
    CHECK_THAT(problems("/s.db", "--" + name),
               Catch::StartsWith(name + ": expected no value, because a file"));
  }
}

TEST_CASE("Settings: one client may have a quarter of the calls, at least one", "[settings]") {
  for (const auto& [all, own] :
       {std::pair{"1", 1}, std::pair{"7", 1}, std::pair{"8", 2}, std::pair{"4000", 1000}}) {
    CAPTURE(all);
    SettingsReader reader;
    REQUIRE(ReadSettings(reader, {"--store", "/s.db", "--max-calls", all, "--max-heavy-calls", all})
                .empty());
    const server::CallLimitOptions& calls = reader.settings().server.calls;
    CHECK(calls.calls.in_all == std::stoi(all));
    CHECK(calls.calls.per_client == own);
    CHECK(calls.heavy.per_client == own);
    CHECK(calls.streams.in_all == own);
    CHECK(calls.streams.per_client == std::max(1, own / 4));
  }
  for (const char* const bad : {"0", "1.5", "-1", "1000001"}) {
    CAPTURE(bad);
    SettingsReader reader;
    CHECK(ReadSettings(reader, {"--store", "/s.db", "--max-calls", bad}).size() == 1);
  }
}

TEST_CASE("Settings: ingests delay a build by at most 10 s or the configured delay", "[settings]") {
  for (const auto& [delay, limit] :
       {std::pair{"0.5", 10}, std::pair{"10", 10}, std::pair{"20", 20}}) {
    CAPTURE(delay);
    SettingsReader reader;
    REQUIRE(ReadSettings(reader, {"--store", "/s.db", "--rebuild-delay", delay}).empty());
    CHECK(reader.settings().server.engine.rebuild_delay_limit == std::chrono::seconds(limit));
    CHECK(reader.CheckForStart().empty());
  }
}

}  // namespace
}  // namespace motiondb::tests::setting_values_test
