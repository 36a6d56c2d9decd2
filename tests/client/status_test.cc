#include <motiondb/v1/server.pb.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <string>

#include "client/cli/server_text.h"
#include "tests/client/fake_server.h"
#include "tests/client/run_motiondb.h"

namespace motiondb::tests::status_test {
namespace {

using Catch::Contains;
using Catch::StartsWith;
using namespace client;  // NOLINT: the functions under test

v1::GetServerStatusResponse SomeStatus() {
  v1::GetServerStatusResponse status;
  status.set_version("0.1.0");
  status.mutable_start_time()->set_seconds(1000);
  status.set_serving(true);
  status.set_call_count(1200);
  status.set_failed_call_count(3);
  status.set_open_call_count(2);
  status.set_open_stream_count(1);
  status.set_queued_call_count(4);
  status.set_request_thread_count(2);
  status.set_authentication_failure_count(9);
  status.set_memory_bytes(300 << 20);
  status.mutable_cpu_time()->set_seconds(61);
  status.set_thread_count(23);
  status.set_open_file_count(40);
  status.set_open_file_limit(1024);
  status.set_store_bytes(2048);
  status.set_disk_bytes(std::int64_t{4} << 30);  // full
  auto* walks = status.add_databases();
  walks->set_name("databases/walks");
  walks->set_clip_count(7);
  walks->set_stored_frame_count(12345);
  walks->set_frame_count(11969);
  walks->set_model_version(3);
  walks->set_byte_count(3 << 20);
  walks->set_open_stream_count(1);
  walks->mutable_model_age()->set_seconds(200);
  walks->mutable_model_build_time()->set_nanos(420'000'000);
  walks->set_succeeded_rebuild_count(12);
  walks->set_failed_rebuild_count(1);
  walks->set_cancelled_rebuild_count(2);
  walks->mutable_rebuild_time()->set_seconds(5);
  walks->set_operation("operations/9");
  walks->set_progress(0.42);
  walks->set_stage("tree");
  status.add_databases()->set_name("databases/empty");
  return status;
}

v1::GetServerStatusResponse IdleStatus() {
  v1::GetServerStatusResponse status = SomeStatus();
  v1::DatabaseStatus& walks = *status.mutable_databases(0);
  walks.clear_failed_rebuild_count();
  walks.clear_cancelled_rebuild_count();
  walks.clear_operation();
  return status;
}

std::string TextOf(const v1::GetServerStatusResponse& status, std::int64_t now_us) {
  return WithStyles(StatusText(status, now_us), false);
}

TEST_CASE("DurationText: two units at most", "[client][cli]") {
  CHECK(DurationText(-3) == "0 s");
  CHECK(DurationText(59) == "59 s");
  CHECK(DurationText(60) == "1 min 0 s");
  CHECK(DurationText(3 * 3600 + 59 * 60 + 59) == "3 h 59 min");
  CHECK(DurationText(50 * 3600) == "2 d 2 h");
}

TEST_CASE("BytesText: uses the largest unit", "[client][cli]") {
  CHECK(BytesText(0) == "0 B");
  CHECK(BytesText(1023) == "1023 B");
  CHECK(BytesText(1536) == "1.5 KiB");
  CHECK(BytesText(std::int64_t{3} << 40) == "3.0 TiB");
  CHECK(BytesText(std::int64_t{3} << 52) == "12288.0 TiB");
}

void AddMethod(const std::string& name, std::int64_t calls, v1::GetServerStatusResponse& status) {
  auto* method = status.add_methods();
  method->set_method(name);
  method->set_call_count(calls);
  method->mutable_p50_time()->set_nanos(2'500'000);
  method->mutable_p95_time()->set_nanos(75'000'000);
  method->mutable_p99_time()->set_seconds(3);
}

TEST_CASE("StatusText: latencies and errors of methods, most calls first", "[client][cli]") {
  v1::GetServerStatusResponse status = SomeStatus();
  AddMethod("ClipService.IngestClip", 7, status);
  AddMethod("QueryService.Recognize", 1200, status);
  for (const auto& [code, count] : {std::pair(5, 3), std::pair(13, 1)}) {
    auto* error = status.mutable_methods(1)->add_errors();
    error->set_code(code);
    error->set_call_count(count);
  }
  const std::string text = TextOf(status, 0);
  CAPTURE(text);
  CHECK_THAT(
      text,
      Contains(
          "CALLS OF                ENDED  P50 (ms)  P95 (ms)  P99 (ms)  ERRORS\n"
          "QueryService.Recognize   1200      2.50      75.0      3000  NOT_FOUND 3, INTERNAL 1\n"
          "ClipService.IngestClip      7      2.50      75.0      3000\n"));
  CHECK_THAT(text, !Contains("more methods"));
  for (int i = 0; i < 12; ++i) AddMethod("Some.Method" + std::to_string(i), i, status);
  const std::string more = TextOf(status, 0);
  CHECK_THAT(more, Contains("Some.Method4 ") && Contains("and 4 more methods\n"));
  CHECK_THAT(more, !Contains("Some.Method3 "));
}

TEST_CASE("StatusText: shows the most active of many databases", "[client][cli]") {
  v1::GetServerStatusResponse status = SomeStatus();  // with two
  for (int i = 0; i < 10; ++i) {
    status.add_databases()->set_name("databases/some" + std::to_string(i));
  }
  CHECK_THAT(TextOf(status, 0), Contains("\nempty ") && !Contains("more databases"));
  status.add_databases()->set_name("databases/large");
  status.mutable_databases(12)->set_stored_frame_count(99'999);
  status.add_databases()->set_name("databases/streams");
  status.mutable_databases(13)->set_open_stream_count(2);
  status.add_databases()->set_name("databases/work");
  status.mutable_databases(14)->set_operation("operations/10");
  const std::string text = TextOf(status, 0);
  CAPTURE(text);
  CHECK_THAT(text, Contains("and 3 more databases: `motiondb list`\n"));
  for (const char* const name : {"\nlarge ", "\nstreams ", "\nwork ", "\nwalks "}) {
    CHECK_THAT(text, Contains(name));
  }
}

TEST_CASE("StatusText: expiry of the certificate", "[client][cli]") {
  v1::GetServerStatusResponse status = SomeStatus();
  status.set_encrypted(true);
  status.mutable_certificate_end_time()->set_seconds(1'800'000'000);
  CHECK_THAT(
      TextOf(status, 0),
      Contains("connections           encrypted, certificate valid until 2027-01-15 08:00 UTC, "
               "authentication: DISABLED"));
}

TEST_CASE("StatusText: failed writes and heavy calls", "[client][cli]") {
  v1::GetServerStatusResponse status = SomeStatus();
  status.set_not_ready_reason("queries are answered, but nothing is stored: the disk is full");
  status.set_failed_write_count(1);
  status.set_running_heavy_call_count(2);
  const std::string text = TextOf(status, 0);
  CHECK_THAT(text, Contains("0.1.0, serving, but not ready: queries are answered, but nothing is "
                            "stored: the disk is full\n"));
  CHECK_THAT(text, Contains("log 0 B, 1 failed write; "));
  CHECK_THAT(text, Contains("4; 2 threads; 2 heavy calls running\n"));
}

TEST_CASE("StatusText: an unknown disk size is omitted", "[client][cli]") {
  v1::GetServerStatusResponse status = SomeStatus();
  status.clear_disk_bytes();
  CHECK_THAT(TextOf(status, 0), Contains("store                 2.0 KiB, log 0 B\n"));
}

TEST_CASE("StatusText: the server, then its databases and their builds", "[client][cli]") {
  const std::string text = TextOf(SomeStatus(), 1'065'000'000);
  CAPTURE(text);
  CHECK_THAT(text, StartsWith("motiondbd             0.1.0, serving\n"));
  CHECK_THAT(text, Contains("up                    1 min 5 s\n"));
  CHECK_THAT(text, Contains("not encrypted, authentication: DISABLED\n"));
  CHECK_THAT(text, Contains("1200 ended, 3 of them with a server error; 2 in flight\n"));
  CHECK_THAT(text, Contains("waiting for a thread  4; 2 threads\n"));
  CHECK_THAT(text, Contains("unauthenticated       9 calls\n"));
  CHECK_THAT(text, Contains("process               300.0 MiB of memory, 1 min 1 s of CPU time, "
                            "23 threads, 40 of 1024 files open\n"));
  CHECK_THAT(text, Contains("store                 2.0 KiB, log 0 B; 0 B of 4.0 GiB free on its "
                            "disk\n"));
  CHECK_THAT(text, Contains("DATABASE  CLIPS  FRAMES  SIZE (MiB)  STREAMS\n"
                            "walks         7   12345        3.00        1\n"
                            "empty         0       0        0.00        0\n"));
  CHECK_THAT(
      text,
      Contains("MODEL OF  VERSION  FRAMES  AGE (h)  BUILT IN (s)  REBUILDS  TIME (s)  FAILED  "
               "CANCELLED  DONE (%)  STAGE\n"
               "walks           3   11969     0.06          0.42        12      5.00       1  "
               "        2        42  tree\n"
               "empty        none                                        0\n"));
  // Columns without any content are left out.
  CHECK_THAT(TextOf(IdleStatus(), 0), Contains("REBUILDS  TIME (s)\n") && !Contains("FAILED"));
  CHECK_THAT(text, !Contains("corrupt"));
}

TEST_CASE("StatusText: lists at most five corrupt items", "[client][cli]") {
  v1::GetServerStatusResponse status = SomeStatus();
  status.clear_databases();
  for (int i = 0; i < 8; ++i) {
    auto* corruption = status.add_corruptions();
    corruption->set_resource("databases/walks/clips/c" + std::to_string(i));
    corruption->set_description("checksum");
  }
  const std::string text = TextOf(status, 0);
  CAPTURE(text);
  CHECK_THAT(text, Contains("no databases; create one"));
  CHECK_THAT(text, Contains("corrupt: 8") && Contains("databases/walks/clips/c4: checksum\n") &&
                       Contains("and 3 more\n"));
  CHECK_THAT(text, !Contains("clips/c5"));
}

TEST_CASE("motiondb status: text, JSON and --watch", "[client][cli]") {
  FakeServer server;
  server.Answer("GetServerStatus", SomeStatus());
  const auto text = RunMotiondb(server.address(), {"status"});
  CAPTURE(text.err);
  CHECK(text.exit_code == 0);
  CHECK_THAT(text.out, Contains("walks"));
  CHECK_THAT(RunMotiondb(server.address(), {"status", "--json"}).out,
             StartsWith("{\"version\":\"0.1.0\"") && Contains("\"frame_count\":11969"));

  FakeServer ending;
  ending.Answer("GetServerStatus", SomeStatus());
  ending.Answer("GetServerStatus", SomeStatus());
  ending.Fail("GetServerStatus", 14, "gone");
  const auto watched = RunMotiondb(ending.address(), {"status", "--json", "--watch", "0.01"});
  CHECK(watched.exit_code == 1);
  CHECK_THAT(watched.err, Contains("not available"));
  const std::string line = "{\"version\"";
  const auto second = watched.out.find(line, 1);
  CHECK(second != std::string::npos);
  CHECK(watched.out.find(line, second + 1) == std::string::npos);
}

}  // namespace
}  // namespace motiondb::tests::status_test
