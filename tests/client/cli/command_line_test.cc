#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/model.pb.h>
#include <motiondb/v1/operation.pb.h>

#include <catch2/catch.hpp>

#include "tests/client/fake_server.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/project_paths.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::command_line_test {
namespace {

using Catch::Contains;
using Catch::StartsWith;

TEST_CASE("motiondb: help and version succeed on standard output", "[client][cli]") {
  const auto help = RunMotiondb("", {"--help"});
  CHECK(help.exit_code == 0);
  CHECK(help.err == "");
  for (const char* command :
       {"create", "ingest", "list", "describe", "recognize", "estimate", "predict", "observe",
        "plan", "dump", "export", "delete", "reprocess", "operations", "status"}) {
    CHECK_THAT(help.out, Contains(command));
    CHECK(RunMotiondb("", {command, "--help"}).exit_code == 0);
  }
  CHECK_THAT(RunMotiondb("", {"--version"}).out, StartsWith("motiondb "));
}

TEST_CASE("motiondb: wrong usage fails on standard error", "[client][cli]") {
  const std::vector<std::vector<std::string>> wrong = {
      {},
      {"nonsense"},
      {"describe"},
      {"describe", "walks", "extra"},
      {"recognize", "walks", "a.bvh", "--window", "wide"},
      {"predict", "walks", "a.bvh", "--at", "1", "--every", "1"},
      {"create", "walks", "--scaling", "much"},
      {"create", "walks", "--frame-rate", "0"},
      {"status", "--watch", "1e-9"}};
  for (const auto& arguments : wrong) {
    const auto result = RunMotiondb("", arguments);
    CAPTURE(result.err);
    CHECK(result.exit_code == 2);
    CHECK(result.out == "");
    CHECK_THAT(result.err, StartsWith("motiondb: "));
  }
  CHECK_THAT(RunMotiondb("", {"nonsense"}).err, Contains("unknown command: nonsense"));
}

TEST_CASE("motiondb: refuses an invalid timeout, accepts a long one", "[client][cli]") {
  for (const char* seconds :
       {"1e-9", "0.0009", "0", "-0", "-1", "nan", "inf", "-inf", "soon", ""}) {
    const auto result = RunMotiondb("", {"list", std::string("--timeout=") + seconds});
    CAPTURE(seconds, result.err);
    CHECK(result.exit_code == 2);
    CHECK_THAT(result.err, Contains("--timeout"));
  }
  CHECK_THAT(RunMotiondb("", {"list", "--timeout", "1e-9"}).err,
             Contains("--timeout: expected a number of at least 0.001 seconds, got 1e-9"));
  FakeServer server;
  server.Answer("ListDatabases", v1::ListDatabasesResponse());
  CHECK(RunMotiondb(server.address(), {"list", "--timeout", "1e300"}).exit_code == 0);
}

TEST_CASE("motiondb: endless files are refused", "[client][cli]") {
  FakeServer server;
  const std::vector<std::vector<std::string>> endless = {
      {"create", "walks", "--marker-set", "/dev/zero"},
      {"ingest", "walks", "--list", "/dev/zero"},
      {"recognize", "walks", "/dev/zero"},
      {"plan", "walks", "--goal", "1,0,0", "--observation", "/dev/zero"},
      {"restore", "/dev/zero"},
      {"list", "--token-file", "/dev/zero"},
      {"list", "--tls-ca", "/dev/zero"},
      {"list", "--tls-certificate", "/dev/zero", "--tls-key", "/dev/zero"}};
  for (const auto& arguments : endless) {
    const auto result = RunMotiondb(server.address(), arguments);
    CAPTURE(arguments, result.err);
    CHECK(result.exit_code == 1);
    CHECK_THAT(result.err, Contains("/dev/zero: is larger than ") ||
                               Contains("/dev/zero: is not a regular file"));
  }
}

TEST_CASE("motiondb: without a server, the error names the address and what to do",
          "[client][cli]") {
  const auto result = RunMotiondb("127.0.0.1:1", {"list"});
  CHECK(result.exit_code == 1);
  CHECK(result.out == "");
  CHECK_THAT(result.err, StartsWith("motiondb: ") && Contains("127.0.0.1:1") &&
                             Contains("--server") && Contains("MOTIONDB_SERVER"));
}

TEST_CASE("motiondb: global options before or after the command", "[client][cli]") {
  FakeServer server;
  v1::ListDatabasesResponse databases;
  databases.add_databases()->set_name("databases/a");
  server.Answer("ListDatabases", databases);
  const auto before = RunMotiondb("127.0.0.1:1", {"--json", "--server", server.address(), "list"});
  const auto after = RunMotiondb("127.0.0.1:1", {"list", "--server=" + server.address(), "--json"});
  CHECK(before.exit_code == 0);
  CHECK_THAT(before.out, StartsWith("{\"name\":\"databases/a\""));
  CHECK(after.exit_code == 0);
  CHECK(after.out == before.out);
}

TEST_CASE("motiondb create: settings and the text of a marker-set file are sent", "[client][cli]") {
  FakeServer server;
  v1::CreateDatabaseResponse created;
  created.mutable_database()->set_name("databases/walks");
  server.Answer("CreateDatabase", created);
  const TemporaryFolder folder;
  const auto file = folder.Write("feet.markers", "two feet");
  CHECK(RunMotiondb(server.address(), {"create", "walks"}).exit_code == 0);
  CHECK(RunMotiondb(server.address(),
                    {"create", "databases/walks", "--frame-rate", "120", "--min-frames", "8",
                     "--scaling", "none", "--marker-set", file.string()})
            .exit_code == 0);
  const auto requests = server.Requests<v1::CreateDatabaseRequest>("CreateDatabase");
  REQUIRE(requests.size() == 2);
  CHECK(requests[0].database_id() == "walks");
  CHECK(requests[0].database().frame_rate_hz() == 60);
  CHECK(requests[0].database().min_frames() == 16);
  CHECK(requests[0].database().scaling() == v1::SCALING_KIND);
  CHECK(requests[0].database().marker_set() == "standard34");
  CHECK(requests[1].database_id() == "walks");
  CHECK(requests[1].database().frame_rate_hz() == 120);
  CHECK(requests[1].database().min_frames() == 8);
  CHECK(requests[1].database().scaling() == v1::SCALING_NONE);
  CHECK(requests[1].database().marker_set().empty());  // the file names the set
  CHECK(requests[1].database().marker_set_file() == "two feet");
  CHECK_THAT(RunMotiondb(server.address(), {"create", "w", "--marker-set", "none.txt"}).err,
             StartsWith("motiondb: --marker-set: ") && Contains("none.txt"));
}

TEST_CASE("motiondb list: a table, or one JSON message per line", "[client][cli]") {
  FakeServer server;
  v1::ListClipsResponse first, second;
  first.add_clips()->set_name("databases/walks/clips/a");
  first.set_next_page_token("t");
  second.add_clips()->set_name("databases/walks/clips/b");
  server.Answer("ListClips", first);
  server.Answer("ListClips", second);
  const auto json = RunMotiondb(server.address(), {"list", "walks", "--json"});
  CHECK(json.exit_code == 0);
  CHECK(std::count(json.out.begin(), json.out.end(), '\n') == 2);
  CHECK_THAT(json.out, Contains("\"frame_count\":0") && Contains("\"duration_seconds\":0"));
  CHECK(server.Requests<v1::ListClipsRequest>("ListClips")[0].parent() == "databases/walks");
  const auto text = RunMotiondb(server.address(), {"list", "walks"});
  CHECK_THAT(text.out, StartsWith("CLIP"));
}

TEST_CASE("motiondb describe: JSON has the field names of the proto", "[client][cli]") {
  FakeServer server;
  v1::DatabaseStatistics description;
  description.set_name("databases/walks");
  description.set_frame_count(100);
  description.add_nodes_per_layer(1);
  server.Answer("GetDatabase", WithStatistics(description));
  const auto json = RunMotiondb(server.address(), {"describe", "walks", "--json"});
  for (const char* field :
       {"\"frame_count\":100", "\"clip_count\":0", "\"layer_count\":0", "\"node_count\":0",
        "\"bottom_node_count\":0", "\"nodes_per_layer\":[1]", "\"model_version\":0",
        "\"build_seconds\":0"}) {
    CHECK_THAT(json.out, Contains(field));
  }
  CHECK_THAT(RunMotiondb(server.address(), {"describe", "walks"}).out, Contains("100"));
}

TEST_CASE("motiondb: prints the error of the server", "[client][cli]") {
  FakeServer server;
  server.Fail("GetDatabase", 5, "there is no database \"walks\"");
  const auto result = RunMotiondb(server.address(), {"describe", "walks", "--json"});
  CHECK(result.exit_code == 1);
  CHECK(result.out == "");
  CHECK(result.err == "motiondb: there is no database \"walks\"\n");
}

TEST_CASE("motiondb: fails if the answer cannot be written", "[client][cli]") {
  FakeServer server;
  v1::DatabaseStatistics description;
  server.Answer("GetDatabase", WithStatistics(description));
  for (const char* json : {"", "--json"}) {
    const auto result = RunProgram({"sh", "-c",
                                    MotiondbProgram() + " describe walks --server " +
                                        server.address() + " " + json + " > /dev/full"});
    CHECK(result.exit_code == 1);
    CHECK_THAT(result.err, StartsWith("motiondb: "));
  }
}

TEST_CASE("motiondb export: writes the files and prints their paths", "[client][cli]") {
  FakeServer server;
  v1::ExportClipResponse header, block;
  header.mutable_header()->mutable_clip()->set_file_name("a.bvh");
  block.set_file_block(std::string("bytes\0\r\n", 8));
  server.Answer("ExportClip", header, block);
  const TemporaryFolder folder;
  const auto result =
      RunMotiondb(server.address(), {"export", "walks", "a", "--out", (folder / "out").string()});
  CHECK(result.exit_code == 0);
  CHECK(result.out == (folder / "out/a.bvh").string() + "\n");
  CHECK(ReadFile(folder / "out/a.bvh") == std::string("bytes\0\r\n", 8));
  CHECK(server.Requests<v1::ExportClipRequest>("ExportClip")[0].name() ==
        "databases/walks/clips/a");
}

TEST_CASE("motiondb delete: on a terminal, asks before deleting a database", "[client][cli]") {
  FakeServer server;
  server.Answer("DeleteDatabase", v1::DeleteDatabaseResponse());
  const auto deleted = [&] {
    return server.Requests<v1::DeleteDatabaseRequest>("DeleteDatabase").size();
  };
  const auto refused = RunMotiondb(server.address(), {"delete", "walks"}, {true, false, "yes\n"});
  CHECK(refused.exit_code == 1);
  CHECK_THAT(refused.err, Contains("Type walks") && Contains("was not deleted"));
  CHECK(deleted() == 0);
  CHECK(RunMotiondb(server.address(), {"delete", "walks"}, {true, false, "walks\n"}).exit_code ==
        0);
  CHECK(deleted() == 1);
  CHECK(RunMotiondb(server.address(), {"delete", "walks", "--yes"}, {true, false, ""}).exit_code ==
        0);
  CHECK(deleted() == 2);
  CHECK(RunMotiondb(server.address(), {"delete", "walks", "--json"}).out == "{}\n");
  CHECK(deleted() == 3);
}

TEST_CASE("motiondb delete: the help states that scripts are not asked", "[client][cli]") {
  // The help wraps lines.
  const auto help =
      RunProgram({"sh", "-c", MotiondbProgram() + " delete --help | tr -s ' \n' ' '"});
  CHECK_THAT(help.out, Contains("If standard input is not a terminal, as in a script, it never "
                                "asks"));
}

TEST_CASE("motiondb delete: after deleting a clip, waits for the new model", "[client][cli]") {
  FakeServer server;
  v1::DeleteClipResponse started;
  started.mutable_operation()->set_name("operations/9");
  server.Answer("DeleteClip", started);
  v1::WaitOperationResponse done;
  done.mutable_operation()->set_name("operations/9");
  done.mutable_operation()->set_state(v1::OPERATION_STATE_SUCCEEDED);
  server.Answer("WaitOperation", done);
  const auto text = RunMotiondb(server.address(), {"delete", "walks", "a"});
  CHECK(text.exit_code == 0);
  CHECK(text.out == "deleted clip a; no clip is left, so there is no model now\n");
  CHECK_THAT(RunMotiondb(server.address(), {"delete", "walks", "a", "--json"}).out,
             Contains("OPERATION_STATE_SUCCEEDED"));
}

TEST_CASE("motiondb reprocess: waits, and lists the clips that were not derived", "[client][cli]") {
  FakeServer server;
  v1::ReprocessDatabaseResponse started;
  started.mutable_operation()->set_name("operations/9");
  server.Answer("ReprocessDatabase", started);
  v1::WaitOperationResponse done;
  done.mutable_operation()->set_name("operations/9");
  done.mutable_operation()->set_kind(v1::OPERATION_KIND_REPROCESS);
  done.mutable_operation()->set_stage("done, clips derived again: 2");
  done.mutable_operation()->set_state(v1::OPERATION_STATE_SUCCEEDED);
  server.Answer("WaitOperation", done);
  v1::DatabaseStatistics description;
  description.set_underived_clip_count(1);
  description.add_underived_clips()->set_name("databases/walks/clips/a");
  description.mutable_underived_clips(0)->set_reason("chunk 0 is corrupt");
  server.Answer("GetDatabase", WithStatistics(description));
  const auto text = RunMotiondb(server.address(), {"reprocess", "walks"});
  CHECK(text.exit_code == 0);
  CHECK(
      text.out ==
      "reprocessed walks: done, clips derived again: 2; no clip is left, so there is no model now\n"
      "1 clip could not be derived again from its file:\n"
      "  a: chunk 0 is corrupt\n");
  CHECK_THAT(RunMotiondb(server.address(), {"reprocess", "walks", "--json"}).out,
             Contains("OPERATION_KIND_REPROCESS"));
  FakeServer other;
  other.Answer("ReprocessDatabase", started);
  done.mutable_operation()->set_state(v1::OPERATION_STATE_CANCELLED);
  other.Answer("WaitOperation", done);
  CHECK(RunMotiondb(other.address(), {"reprocess", "walks"}).exit_code == 1);
}

TEST_CASE("motiondb operations: list, wait and cancel", "[client][cli]") {
  FakeServer server;
  v1::ListOperationsResponse list;
  auto* failed = list.add_operations();
  failed->set_name("operations/9");
  failed->set_state(v1::OPERATION_STATE_FAILED);
  failed->mutable_error()->set_code(13);
  failed->mutable_error()->set_message("no memory");
  failed->mutable_error()->add_details()->set_type_url("type.googleapis.com/google.rpc.BadRequest");
  server.Answer("ListOperations", list);
  v1::WaitOperationResponse wait;
  *wait.mutable_operation() = *failed;
  server.Answer("WaitOperation", wait);
  v1::CancelOperationResponse cancel;
  *cancel.mutable_operation() = *failed;
  server.Answer("CancelOperation", cancel);
  CHECK_THAT(RunMotiondb(server.address(), {"operations", "list", "walks"}).out,
             Contains("failed") && Contains("no memory"));
  CHECK_THAT(RunMotiondb(server.address(), {"operations", "list", "--json"}).out,
             StartsWith("{\"name\":\"operations/9\""));
  const auto waited = RunMotiondb(server.address(), {"operations", "wait", "9"});
  CHECK(waited.exit_code == 1);
  CHECK_THAT(waited.err, Contains("no memory"));
  CHECK(RunMotiondb(server.address(), {"operations", "cancel", "9", "--json"}).exit_code == 0);
}

}  // namespace
}  // namespace motiondb::tests::command_line_test
