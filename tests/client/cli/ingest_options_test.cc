#include <fmt/format.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/operation.pb.h>

#include <catch2/catch.hpp>

#include "tests/client/cli/ingest_answers.h"
#include "tests/client/fake_server.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"

namespace motiondb::tests::ingest_options_test {
namespace {

using Catch::Contains;
using Catch::StartsWith;

// A server that accepts all clips, and two files.
struct TwoFiles {
  TwoFiles() {
    ServeDatabase(server);
    server.Answer("IngestClip", StoredClip("a", "operations/6"));
    server.Answer("IngestClip", StoredClip("b", "operations/7"));
  }

  // Runs `motiondb ingest walks A B OPTIONS...`.
  ProgramResult Ingest(const std::vector<std::string>& options,
                       const ProgramTerminal& terminal = {}) {
    std::vector<std::string> arguments = {"ingest", "walks", a, b};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return RunMotiondb(server.address(), arguments, terminal);
  }

  FakeServer server;
  TemporaryFolder folder;
  std::string a = folder.Write("walk/bk_01.bvh", "a").string();
  std::string b = folder.Write("run/tr_02.bvh", "b").string();
};

std::size_t WaitCount(const FakeServer& server) {
  return server.Requests<v1::WaitOperationRequest>("WaitOperation").size();
}

TEST_CASE("motiondb ingest: a folder, a pattern and standard input", "[client][cli]") {
  TwoFiles files;
  const std::string folder = files.folder.path().string();
  const std::string c = files.folder.Write("c.trc", "c").string();
  files.folder.Write("notes.txt", "");
  const auto result = RunMotiondb(files.server.address(),
                                  {"ingest", "walks", folder + "/walk", folder + "/*/tr_*", "-"},
                                  {.input_text = "\n" + c + "\n"});
  CHECK(result.err == "");
  CHECK_THAT(result.out, StartsWith("ingested 3 clips, 300 frames; model 3"));
  const auto headers = IngestHeaders(files.server);
  REQUIRE(headers.size() == 3);
  CHECK(headers[0].file_name() == "bk_01.bvh");
  CHECK(headers[1].file_name() == "tr_02.bvh");
  CHECK(headers[2].file_name() == "c.trc");
}

TEST_CASE("motiondb ingest: folders and patterns are checked before the server is called",
          "[client][cli]") {
  const TemporaryFolder folder;
  const std::string name = folder.path().string();
  const auto empty = RunMotiondb("127.0.0.1:1", {"ingest", "walks", "a.bvh", name});
  CHECK(empty.exit_code == 1);
  CHECK_THAT(empty.err, StartsWith("motiondb: " + name + ": has no motion files (.bvh, .amc,"));
  CHECK(RunMotiondb("127.0.0.1:1", {"ingest", "walks", name + "/*.bvh"}).err ==
        "motiondb: " + name + "/*.bvh: no file matches\n");
}

TEST_CASE("motiondb ingest --dry-run: checks the files and stores nothing", "[client][cli]") {
  TwoFiles files;
  const auto result = files.Ingest({"--dry-run"});
  CHECK(result.exit_code == 0);
  CHECK(result.err == "");
  CHECK(result.out == "would store 2 clips, 200 frames\n");
  const auto headers = IngestHeaders(files.server);
  REQUIRE(headers.size() == 2);
  CHECK(headers[0].validate_only());
  CHECK_FALSE(headers[0].replace());
  CHECK(WaitCount(files.server) == 0);
}

TEST_CASE("motiondb ingest --dry-run: reports a file that would be refused", "[client][cli]") {
  FakeServer server;
  ServeDatabase(server);
  server.Fail("IngestClip", 3, "a.bvh: expected HIERARCHY");
  const TemporaryFolder folder;
  const std::string a = folder.Write("a.bvh", "a").string();
  const auto result = RunMotiondb(server.address(), {"ingest", "walks", a, "--dry-run"});
  CHECK(result.exit_code == 1);
  CHECK(result.out == "");
  CHECK(result.err == "motiondb: " + a +
                          ": expected HIERARCHY\n"
                          "motiondb: 1 of 1 file would not be ingested\n");
}

TEST_CASE("motiondb ingest: --replace and --force are sent", "[client][cli]") {
  TwoFiles files;
  CHECK(files.Ingest({"--replace", "--force"}).exit_code == 0);
  CHECK(files.Ingest({}).exit_code == 0);
  const auto headers = IngestHeaders(files.server);
  REQUIRE(headers.size() == 4);
  CHECK(headers[1].replace());
  CHECK(headers[1].conventions().force());
  CHECK_FALSE(headers[1].validate_only());
  CHECK_FALSE(headers[3].replace());
  CHECK_FALSE(headers[3].conventions().force());
}

TEST_CASE("motiondb ingest --quiet: prints only errors", "[client][cli]") {
  TwoFiles files;
  const auto result = files.Ingest({"--quiet"}, {.error = true});
  CHECK(result.exit_code == 0);
  CHECK(result.out == "");
  CHECK(result.err == "");
  CHECK(WaitCount(files.server) == 2);
  const auto missing = files.Ingest({"--quiet", "none.bvh"});
  CHECK(missing.exit_code == 1);
  CHECK(missing.out == "");
  CHECK(missing.err ==
        "motiondb: none.bvh: no such file\nmotiondb: 1 of 3 files was not ingested\n");
  for (const char* other : {"--verbose", "--json"}) {
    const auto refused = files.Ingest({"--quiet", other});
    CHECK(refused.exit_code == 2);
    CHECK(refused.err ==
          std::string("motiondb: --quiet excludes ") + other + "\nTry `motiondb ingest --help`.\n");
  }
}

TEST_CASE("motiondb ingest --quiet: a failed rebuild is an error", "[client][cli]") {
  FakeServer server;
  server.Answer("GetDatabase", v1::GetDatabaseResponse());
  server.Answer("IngestClip", StoredClip("a", "operations/1"));
  v1::WaitOperationResponse failed;
  failed.mutable_operation()->set_state(v1::OPERATION_STATE_FAILED);
  failed.mutable_operation()->mutable_error()->set_code(8);
  failed.mutable_operation()->mutable_error()->set_message("out of disk");
  server.Answer("WaitOperation", failed);
  const TemporaryFolder folder;
  const auto result = RunMotiondb(
      server.address(), {"ingest", "walks", folder.Write("a.bvh", "a").string(), "--quiet"});
  CHECK(result.exit_code == 1);
  CHECK(result.out == "");
  CHECK_THAT(result.err, Contains("out of disk") && Contains("; 1 clip is stored"));
}

TEST_CASE("motiondb ingest --no-wait: names the operation that builds the model", "[client][cli]") {
  TwoFiles files;
  const auto result = files.Ingest({"--no-wait"});
  CHECK(result.exit_code == 0);
  CHECK(result.err == "");
  CHECK(result.out ==
        "stored 2 clips, 200 frames; the model is built by operations/7 (motiondb operations wait "
        "7)\n");
  CHECK(WaitCount(files.server) == 0);
}

TEST_CASE("motiondb ingest --label-from: reads label and subject from the path", "[client][cli]") {
  TwoFiles files;
  const std::string list =
      files.folder
          .Write("list.tsv", "path\tlabel\tsubject\nwalk/bk_01.bvh\tjog\t\nrun/tr_02.bvh\t\tx\n")
          .string();
  const auto result = files.Ingest({"--list", list, "--label-from", "{label}/{subject}_*"});
  CHECK(result.err == "");
  const auto headers = IngestHeaders(files.server);
  REQUIRE(headers.size() == 4);
  CHECK(headers[0].label() == "walk");
  CHECK(headers[0].subject() == "bk");
  CHECK(headers[1].label() == "run");
  CHECK(headers[1].subject() == "tr");
  CHECK(headers[2].label() == "jog");
  CHECK(headers[2].subject() == "");
  CHECK(headers[3].label() == "run");
  CHECK(headers[3].subject() == "x");
}

TEST_CASE("motiondb ingest --label-from: errors come before the server is called",
          "[client][cli]") {
  const auto ingest = [](const std::vector<std::string>& options) {
    std::vector<std::string> arguments = {"ingest", "walks", "walk/07_01.amc"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return RunMotiondb("127.0.0.1:1", arguments);
  };
  const auto no_match = ingest({"--label-from", "{label}-*"});
  CHECK(no_match.exit_code == 1);
  CHECK(no_match.err == "motiondb: walk/07_01.amc: does not match --label-from '{label}-*'\n");
  const auto no_label = ingest({"--label-from", "{subject}/*"});
  CHECK(no_label.exit_code == 2);
  CHECK_THAT(no_label.err, StartsWith("motiondb: --label-from: expected {label} in the pattern\n"));
  const auto both = ingest({"--label-from", "{label}/*", "--label", "walk"});
  CHECK(both.exit_code == 2);
  CHECK_THAT(both.err, Contains("excludes"));
}

TEST_CASE("motiondb ingest: failures with the same reason are printed together", "[client][cli]") {
  FakeServer server;
  ServeDatabase(server);
  const TemporaryFolder folder;
  std::vector<std::string> arguments = {"ingest", "walks"};
  for (int i = 0; i < 8; ++i) {
    const std::string name = fmt::format("c{}.bvh", i);
    arguments.push_back(folder.Write(name, "x").string());
    server.Fail("IngestClip", 3,
                i == 3 ? "c3.bvh:3: expected CHANNELS 3, got 2"
                       : fmt::format("{}:{}: a leg of {}.5 m, {:g} m per unit", name, i, i,
                                     i == 1 ? -0.01 : 25.4));
  }
  const auto result = RunMotiondb(server.address(), arguments);
  CHECK(result.exit_code == 1);
  CHECK(result.out == "");
  std::string expected = "motiondb: 7 files; the first: a leg of 0.5 m, 25.4 m per unit\n";
  for (const int i : {0, 1, 2, 4, 5}) expected += "    " + arguments[2 + i] + "\n";
  expected += "    ... and 2 more\n";
  expected += "motiondb: " + arguments[2 + 3] + ":3: expected CHANNELS 3, got 2\n";
  CHECK(result.err == expected + "motiondb: 8 of 8 files were not ingested\n");
}

TEST_CASE("motiondb ingest: paths of grouped failures have no control characters",
          "[client][cli]") {
  FakeServer server;
  ServeDatabase(server);
  const auto result =
      RunMotiondb(server.address(), {"ingest", "walks", "none/a\x1b.bvh", "none/b\n.bvh"});
  CHECK(result.err ==
        "motiondb: 2 files: no such file\n    none/a\xEF\xBF\xBD.bvh\n    none/b\xEF\xBF\xBD.bvh\n"
        "motiondb: 2 of 2 files were not ingested\n");
}

}  // namespace
}  // namespace motiondb::tests::ingest_options_test
