#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/operation.pb.h>

#include <catch2/catch.hpp>

#include "client/cli/ingest_batch.h"
#include "tests/client/cli/ingest_answers.h"
#include "tests/client/fake_server.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"

namespace motiondb::tests::ingest_command_test {
namespace {

using Catch::Contains;
using Catch::StartsWith;

TEST_CASE("motiondb ingest: sends files and a list, and waits for the new model", "[client][cli]") {
  FakeServer server;
  ServeDatabase(server);
  server.Answer("IngestClip", StoredClip("a", "operations/1"));
  server.Answer("IngestClip", StoredClip("b", "operations/2"));
  const TemporaryFolder folder;
  const std::string a = folder.Write("a.bvh", "a").string();
  folder.Write("cmu/07_01.amc", "amc");
  folder.Write("cmu/07.asf", "asf");
  const std::string list =
      folder.Write("sets/list.tsv", "path\tlabel\r\n../cmu/07_01.amc\twalk\r\n").string();
  const auto result =
      RunMotiondb(server.address(), {"ingest", "walks", a, "--list", list, "--label", "jog",
                                     "--subject", "bk", "--up-axis", "z"});
  CHECK(result.err == "");
  CHECK(result.exit_code == 0);
  CHECK(
      result.out ==
      "ingested 2 clips, 200 frames; model 3: 19 clips, 6552 frames, 0 layers, built in 4.20 s\n");
  const auto headers = IngestHeaders(server);
  REQUIRE(headers.size() == 2);
  CHECK(headers[0].parent() == "databases/walks");
  CHECK(headers[0].file_name() == "a.bvh");
  CHECK(headers[0].label() == "jog");
  CHECK(headers[0].subject() == "bk");
  CHECK(headers[0].conventions().up_axis() == v1::UP_AXIS_Z);
  CHECK(headers[1].file_name() == "07_01.amc");
  CHECK(headers[1].skeleton_file_name() == "07.asf");
  CHECK(headers[1].label() == "walk");
  CHECK(headers[1].subject() == "bk");
  // The last rebuild includes all clips.
  for (const auto& wait : server.Requests<v1::WaitOperationRequest>("WaitOperation")) {
    CHECK(wait.name() == "operations/2");
  }
}

TEST_CASE("motiondb ingest: title, description, tags and fields are sent with the file",
          "[client][cli]") {
  FakeServer server;
  ServeDatabase(server);
  server.Answer("IngestClip", StoredClip("a", "operations/1"));
  server.Answer("IngestClip", StoredClip("b", "operations/2"));
  const TemporaryFolder folder;
  const std::string a = folder.Write("a.bvh", "a").string();
  folder.Write("b.bvh", "b");
  const std::string list =
      folder
          .Write("list.tsv", "path\tlabel\ttitle\ttags\tfield.run:text\nb.bvh\twalk\tB\tslow\t07\n")
          .string();
  const auto result =
      RunMotiondb(server.address(),
                  {"ingest", "walks", a, "--list", list, "--title", "T", "--description", "D",
                   "--tag", "x", "--tag", "y", "--field", "run:text=01", "--field", "kg=72.5"});
  CHECK(result.err == "");
  CHECK(result.exit_code == 0);
  const auto headers = IngestHeaders(server);
  REQUIRE(headers.size() == 2);
  CHECK(headers[0].title() == "T");
  CHECK(headers[0].description() == "D");
  CHECK(std::vector<std::string>(headers[0].tags().begin(), headers[0].tags().end()) ==
        std::vector<std::string>{"x", "y"});
  CHECK(headers[0].fields().at("run").text() == "01");
  CHECK(headers[0].fields().at("kg").number() == 72.5);
  CHECK(headers[1].title() == "B");
  CHECK(headers[1].description() == "D");
  CHECK(std::vector<std::string>(headers[1].tags().begin(), headers[1].tags().end()) ==
        std::vector<std::string>{"slow", "x", "y"});
  CHECK(headers[1].fields().at("run").text() == "07");
  CHECK(headers[1].fields().at("kg").number() == 72.5);
  const auto wrong = RunMotiondb(server.address(), {"ingest", "walks", a, "--field", "kg"});
  CHECK(wrong.exit_code == 2);
  CHECK_THAT(wrong.err, Contains("NAME=VALUE"));
}

TEST_CASE("motiondb ingest: prints clip and report of one file, of several with --verbose",
          "[client][cli]") {
  FakeServer server;
  ServeDatabase(server);
  server.Answer("IngestClip", StoredClip("a", "operations/1"));
  const TemporaryFolder folder;
  const std::string a = folder.Write("a.bvh", "a").string();
  const std::string b = folder.Write("b.bvh", "b").string();
  const std::string clip =
      "a  (no label)  100 frames  0.00 s  leg 0.000 m  from  at 0 Hz\n    unit: metre, as given\n";
  CHECK_THAT(RunMotiondb(server.address(), {"ingest", "walks", a}).out,
             StartsWith(clip + "ingested 1 clip, 100 frames; model 3: "));
  CHECK_THAT(RunMotiondb(server.address(), {"ingest", "walks", a, b, "--verbose"}).out,
             StartsWith(clip + clip + "ingested 2 clips, 200 frames; model 3: "));
}

TEST_CASE("motiondb ingest: a bad file does not stop the others, and is reported",
          "[client][cli]") {
  FakeServer server;
  ServeDatabase(server);
  server.Fail("IngestClip", 3, "bad.bvh:7: expected CHANNELS");
  server.Answer("IngestClip", StoredClip("good", "operations/1"));
  const TemporaryFolder folder;
  const std::string bad = folder.Write("bad.bvh", "b").string();
  const std::string good = folder.Write("good.bvh", "g").string();
  const std::string missing = (folder / "missing.bvh").string();
  const auto result =
      RunMotiondb(server.address(), {"ingest", "walks", bad, missing, good, "--json"});
  CHECK(result.exit_code == 1);
  CHECK_THAT(result.out, StartsWith("{\"clip\":{\"name\":\"databases/walks/clips/good\""));
  CHECK(std::count(result.out.begin(), result.out.end(), '\n') == 1);
  CHECK(result.err == "motiondb: " + bad + ":7: expected CHANNELS\nmotiondb: " + missing +
                          ": no such file\nmotiondb: 2 of 3 files were not ingested\n");
  CHECK(server.Requests<v1::WaitOperationRequest>("WaitOperation").size() == 2);
}

TEST_CASE("motiondb ingest: stops immediately if the server is unavailable", "[client][cli]") {
  FakeServer server;
  ServeDatabase(server);
  server.Fail("IngestClip", 14, "shutting down");
  const TemporaryFolder folder;
  const std::string a = folder.Write("a.bvh", "a").string();
  const std::string b = folder.Write("b.bvh", "b").string();
  const auto result = RunMotiondb(server.address(), {"ingest", "walks", a, b});
  CHECK(result.exit_code == 1);
  CHECK(IngestHeaders(server).size() == 1);
  CHECK_THAT(result.err, Contains("shutting down") && Contains("stopped after 0 of 2 files") &&
                             Contains("0 clips are stored"));
}

TEST_CASE("motiondb ingest: reports stored clips if the server stops before the model is built",
          "[client][cli]") {
  FakeServer server;
  server.Answer("GetDatabase", v1::GetDatabaseResponse());
  server.Answer("IngestClip", StoredClip("a", "operations/1"));
  server.Fail("WaitOperation", 14, "the server is stopping");
  const TemporaryFolder folder;
  const auto result =
      RunMotiondb(server.address(), {"ingest", "walks", folder.Write("a.bvh", "a").string()});
  CHECK(result.exit_code == 1);
  CHECK_THAT(result.err, Contains("the server is stopping") &&
                             Contains("; 1 clip is stored, and the server builds the model after "
                                      "its next start\n"));
}

TEST_CASE("motiondb ingest: a missing database is one error", "[client][cli]") {
  FakeServer server;
  server.Fail("GetDatabase", 5, "there is no database \"walks\"");
  const TemporaryFolder folder;
  const std::string a = folder.Write("a.bvh", "a").string();
  const auto result = RunMotiondb(server.address(), {"ingest", "walks", a, a, a});
  CHECK(result.exit_code == 1);
  CHECK(result.err == "motiondb: there is no database \"walks\"\n");
}

TEST_CASE("motiondb ingest: a failed rebuild is an error", "[client][cli]") {
  FakeServer server;
  server.Answer("GetDatabase", v1::GetDatabaseResponse());
  server.Answer("IngestClip", StoredClip("a", "operations/1"));
  v1::WaitOperationResponse failed;
  failed.mutable_operation()->set_state(v1::OPERATION_STATE_FAILED);
  failed.mutable_operation()->mutable_error()->set_code(8);
  failed.mutable_operation()->mutable_error()->set_message("out of disk");
  server.Answer("WaitOperation", failed);
  const TemporaryFolder folder;
  const auto result =
      RunMotiondb(server.address(), {"ingest", "walks", folder.Write("a.bvh", "a").string()});
  CHECK(result.exit_code == 1);
  CHECK_THAT(result.err,
             StartsWith("motiondb: the new model was not built") && Contains("out of disk"));
}

TEST_CASE("motiondb ingest: without files or with an invalid list, it calls no server",
          "[client][cli]") {
  const TemporaryFolder folder;
  const std::string list = folder.Write("list.tsv", "path\tlabel\nonly-a-path\n").string();
  CHECK_THAT(RunMotiondb("127.0.0.1:1", {"ingest", "walks"}).err, Contains("nothing to ingest"));
  const auto result = RunMotiondb("127.0.0.1:1", {"ingest", "walks", "--list", list});
  CHECK(result.exit_code == 1);
  CHECK_THAT(result.err, StartsWith("motiondb: " + list + ":2: expected 2 cells"));
}

TEST_CASE("motiondb ingest: a label that is not UTF-8 is an error of the file", "[client][cli]") {
  FakeServer server;
  ServeDatabase(server);
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", "a").string();
  const auto result = RunMotiondb(server.address(), {"ingest", "walks", file, "--label", "Gr\xFC"});
  CHECK(result.exit_code == 1);
  CHECK_THAT(result.err, StartsWith("motiondb: " + file + ": the label is not UTF-8 text\n"));
  CHECK(IngestHeaders(server).empty());
}

TEST_CASE("motiondb ingest: shows progress only on a terminal", "[client][cli]") {
  FakeServer server;
  ServeDatabase(server);
  server.Answer("IngestClip", StoredClip("a", "operations/1"));
  const TemporaryFolder folder;
  const auto result =
      RunMotiondb(server.address(), {"ingest", "walks", folder.Write("a.bvh", "a").string()},
                  {false, true, ""});
  CHECK(result.exit_code == 0);
  CHECK_THAT(result.err,
             Contains("1 of 1  a.bvh") && Contains("tree, layer 7") && Contains("40 %"));
  CHECK(result.out.find('\r') == std::string::npos);
}

TEST_CASE("motiondb ingest: shows the progress of several files", "[client][cli]") {
  FakeServer server;
  ServeDatabase(server);
  server.Answer("IngestClip", StoredClip("a", "operations/1"));
  const TemporaryFolder folder;
  const std::string a = folder.Write("a.bvh", "a").string();
  const std::string b = folder.Write("b.bvh", "b").string();
  const auto result = RunMotiondb(server.address(), {"ingest", "walks", a, b}, {.error = true});
  CHECK(result.exit_code == 0);
  CHECK_THAT(result.err, Contains("  0 %  1 of 2  a.bvh") && Contains(" 50 %  2 of 2  b.bvh"));
  CHECK_THAT(result.out, StartsWith("ingested 2 clips"));
}

TEST_CASE("FileProgressText: contains the time left after 3 s", "[client][cli]") {
  using client::FileProgressText;
  CHECK(FileProgressText(0, 344, "a.bvh", 9) == "1 of 344  a.bvh");
  CHECK(FileProgressText(11, 344, "07_01.amc", 2.9) == "12 of 344  07_01.amc");
  CHECK(FileProgressText(2, 12, "07_01.amc", 4) == "3 of 12  07_01.amc  about 20 s left");
  CHECK(FileProgressText(11, 344, "07_01.amc", 3.3) ==
        "12 of 344  07_01.amc  about 1 min 40 s left");
}

}  // namespace
}  // namespace motiondb::tests::ingest_command_test
