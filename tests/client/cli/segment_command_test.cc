#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/edit.pb.h>
#include <motiondb/v1/segment.pb.h>

#include <catch2/catch.hpp>

#include "tests/client/fake_server.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"

namespace motiondb::tests::segment_command_test {
namespace {

using Catch::Contains;
using Catch::StartsWith;

v1::Segment Walk() {
  v1::Segment segment;
  segment.set_name("databases/walks/clips/07_01/segments/a");
  segment.set_track("action");
  segment.set_label("walk");
  segment.set_start_seconds(0.5);
  segment.set_end_seconds(2.25);
  segment.set_source(v1::SEGMENT_SOURCE_PERSON);
  segment.set_confidence(0.5);
  return segment;
}

void ServeClips(FakeServer& server, int count) {
  v1::ListClipsResponse response;
  for (int i = 0; i < count; ++i) {
    v1::Clip& clip = *response.add_clips();
    clip.set_name("databases/walks/clips/07_0" + std::to_string(i + 1));
    clip.set_file_name("07_0" + std::to_string(i + 1) + ".bvh");
    clip.set_duration_seconds(4000);
  }
  server.Answer("ListClips", response);
}

TEST_CASE("motiondb segments list", "[client][cli]") {
  FakeServer server;
  v1::ListSegmentsResponse response;
  *response.add_segments() = Walk();
  server.Answer("ListSegments", response);
  const auto result = RunMotiondb(server.address(), {"segments", "list", "walks", "--clip", "07_01",
                                                     "--filter", "f", "--order-by", "label"});
  CHECK(result.out ==
        "SEGMENT  TRACK   FROM (s)  TO (s)  LABEL  SOURCE  CONFIDENCE\n"
        "07_01/a  action      0.50    2.25  walk   person        0.50\n");
  CHECK_THAT(RunMotiondb(server.address(), {"segments", "list", "walks", "--json"}).out,
             StartsWith("{\"name\":\"databases/walks/clips/07_01/segments/a\""));
  const auto requests = server.Requests<v1::ListSegmentsRequest>("ListSegments");
  CHECK(requests[0].parent() == "databases/walks/clips/07_01");
  CHECK(requests[0].filter() == "f");
  CHECK(requests[0].order_by() == "label");
  CHECK(requests[1].parent() == "databases/walks");
}

TEST_CASE("motiondb segments add, update and delete", "[client][cli]") {
  FakeServer server;
  v1::CreateSegmentResponse created;
  *created.mutable_segment() = Walk();
  created.set_revision(7);
  server.Answer("CreateSegment", created);
  v1::UpdateSegmentResponse updated;
  *updated.mutable_segment() = Walk();
  updated.set_revision(8);
  server.Answer("UpdateSegment", updated);
  v1::BatchEditResponse deleted;
  deleted.set_revision(9);
  server.Answer("BatchEdit", deleted);
  CHECK(RunMotiondb(server.address(), {"segments", "add", "walks", "07_01", "--from", "0.5",
                                       "--label", "walk", "--track", "carries", "--confidence",
                                       "0.25", "--source", "suggestion", "--id", "a"})
            .out == "added segment 07_01/a; revision 7\n");
  const auto create = server.Requests<v1::CreateSegmentRequest>("CreateSegment")[0];
  CHECK(create.parent() == "databases/walks/clips/07_01");
  CHECK(create.segment_id() == "a");
  CHECK(create.segment().track() == "carries");
  CHECK(create.segment().source() == v1::SEGMENT_SOURCE_SUGGESTION);
  CHECK(create.segment().confidence() == 0.25);
  CHECK(!create.segment().has_end_seconds());
  CHECK(RunMotiondb(server.address(), {"segments", "update", "walks", "07_01/a", "--to", "3",
                                       "--label", "jog", "--etag", "e"})
            .out == "updated segment 07_01/a; revision 8\n");
  const auto update = server.Requests<v1::UpdateSegmentRequest>("UpdateSegment")[0];
  CHECK(update.segment().name() == "databases/walks/clips/07_01/segments/a");
  CHECK(update.segment().etag() == "e");
  CHECK(update.update_mask().paths_size() == 2);
  CHECK(RunMotiondb(server.address(), {"segments", "delete", "walks", "07_01/a", "07_01/b"}).out ==
        "deleted 2 segments; revision 9\n");
  const auto batch = server.Requests<v1::BatchEditRequest>("BatchEdit")[0];
  REQUIRE(batch.changes_size() == 2);
  CHECK(batch.changes(1).delete_segment().name() == "databases/walks/clips/07_01/segments/b");
}

TEST_CASE("motiondb segments: wrong usage", "[client][cli]") {
  const std::vector<std::vector<std::string>> wrong = {
      {"segments"},
      {"segments", "lst", "walks"},
      {"segments", "add", "walks", "07_01", "--from", "1"},
      {"segments", "add", "walks", "07_01", "--label", "a"},
      {"segments", "add", "walks", "07_01", "--label", "a", "--from", "1", "--confidence", "nan"},
      {"segments", "add", "walks", "07_01", "--label", "a", "--from", "1", "--source", "me"},
      {"segments", "update", "walks", "07_01/a"},
      {"segments", "update", "walks", "a", "--label", "b"},
      {"segments", "delete", "walks", "07_01/"},
      {"segments", "import", "walks", "a.tsv", "--format", "csv"},
      {"segments", "export", "walks", "--format", "textgrid"}};
  for (const auto& arguments : wrong) {
    CAPTURE(arguments);
    CHECK(RunMotiondb("", arguments).exit_code == 2);
  }
  CHECK_THAT(RunMotiondb("", {"segments", "lst"}).err, Contains("did you mean 'list'?"));
}

TEST_CASE(
    "motiondb segments import: transactions of 1,000 changes; the failed one is named by line",
    "[client][cli]") {
  FakeServer server;
  ServeClips(server, 1);
  server.Answer("ListSegments", v1::ListSegmentsResponse());
  server.Answer("BatchEdit", v1::BatchEditResponse());
  server.Fail("BatchEdit", 9, "changes[3].create_segment: overlaps segment 'x' of the same track");
  std::string text = "clip\tstart\tend\tlabel\n";
  for (int i = 0; i < 1500; ++i) {
    text += "07_01\t" + std::to_string(i) + "\t" + std::to_string(i + 1) + "\twalk\n";
  }
  const TemporaryFolder folder;
  const std::string file = folder.Write("labels.tsv", text).string();
  CHECK(RunMotiondb(server.address(), {"segments", "import", "walks", file, "--dry-run"}).out ==
        "would import 1500 new, 0 changed, 0 unchanged\n");
  CHECK(server.Requests<v1::BatchEditRequest>("BatchEdit").empty());
  const auto result = RunMotiondb(server.address(), {"segments", "import", "walks", file});
  CHECK(result.exit_code == 1);
  CHECK(result.err == "motiondb: " + file +
                          ":1005: overlaps segment 'x' of the same track; 1000 of 1500 changes "
                          "stored\n");
  const auto batches = server.Requests<v1::BatchEditRequest>("BatchEdit");
  REQUIRE(batches.size() == 2);
  CHECK(batches[0].changes(1).create_segment().segment_id() == "action-1000-2000");
  CHECK(batches[0].changes(1).create_segment().segment().source() == v1::SEGMENT_SOURCE_IMPORT);
}

TEST_CASE("motiondb segments import: unknown clips are an error, in BABEL a note",
          "[client][cli]") {
  FakeServer server;
  ServeClips(server, 2);
  server.Answer("ListSegments", v1::ListSegmentsResponse());
  v1::BatchEditResponse stored;
  stored.set_revision(4);
  server.Answer("BatchEdit", stored);
  const TemporaryFolder folder;
  const std::string tsv =
      folder.Write("labels.tsv", "clip\tstart\tlabel\n07_1\t0\twalk\n07_02\t0\twalk\n").string();
  const auto wrong = RunMotiondb(server.address(), {"segments", "import", "walks", tsv});
  CHECK(wrong.exit_code == 1);
  CHECK_THAT(wrong.err, Contains("of these names: 07_1; did you mean '07_01'?"));
  CHECK(server.Requests<v1::BatchEditRequest>("BatchEdit").empty());
  const std::string babel =
      folder
          .Write(
              "train.json",
              R"({"1": {"feat_p": "x/07_02.npz", "seq_ann": {"labels": [{"proc_label": "walk"}]}},
                     "2": {"feat_p": "x/99_01.npz", "seq_ann": {"labels": [{"proc_label": "run"}]}}})")
          .string();
  const auto result = RunMotiondb(server.address(), {"segments", "import", "walks", babel});
  CHECK(result.exit_code == 0);
  CHECK(result.out == "imported segments: 1 new, 0 changed, 0 unchanged; revision 4\n");
  CHECK(result.err == "note: not in database 'walks', or several: 1 clip: 99_01\n");
}

TEST_CASE("motiondb segments import: hostile files are errors", "[client][cli]") {
  FakeServer server;
  const TemporaryFolder folder;
  for (const char* format : {"tsv", "json", "babel", "textgrid"}) {
    CHECK(RunMotiondb(server.address(),
                      {"segments", "import", "walks", "/dev/zero", "--format", format})
              .exit_code == 1);
  }
  CHECK(RunMotiondb(server.address(), {"segments", "import", "walks", folder.path().string()})
            .exit_code == 1);
  const auto unknown = RunMotiondb(
      server.address(), {"segments", "import", "walks", folder.Write("a.txt", "").string()});
  CHECK(unknown.exit_code == 2);
  CHECK_THAT(unknown.err, Contains("expected .tsv, .json or .TextGrid, or --format"));
}

TEST_CASE("motiondb segments export: each format", "[client][cli]") {
  FakeServer server;
  ServeClips(server, 2);
  v1::ListSegmentsResponse response;
  *response.add_segments() = Walk();
  server.Answer("ListSegments", response);
  CHECK(RunMotiondb(server.address(), {"segments", "export", "walks"}).out ==
        "clip\tstart\tend\tlabel\ttrack\tconfidence\tsource\n"
        "07_01\t0.5\t2.25\twalk\taction\t0.5\tperson\n");
  const TemporaryFolder folder;
  const std::string json = (folder / "labels.json").string();
  CHECK(RunMotiondb(server.address(), {"segments", "export", "walks", "--out", json}).out ==
        json + ": 1 segment of 1 clip\n");
  CHECK(folder.Read("labels.json") ==
        "[\n{\"clip\":\"07_01\",\"start\":0.5,\"end\":2.25,\"label\":\"walk\",\"track\":\"action\","
        "\"confidence\":0.5,\"source\":\"person\"}\n]\n");
  CHECK_THAT(
      RunMotiondb(server.address(), {"segments", "export", "walks", "--format", "babel"}).out,
      Contains("\"feat_p\": \"07_01.bvh\""));
  const std::string grids = (folder / "grids").string();
  CHECK(RunMotiondb(server.address(),
                    {"segments", "export", "walks", "--format", "textgrid", "--out", grids})
            .exit_code == 0);
  CHECK_THAT(folder.Read("grids/07_01.TextGrid"), StartsWith("File type = \"ooTextFile\"\n"));
  const std::string grid = (folder / "one.TextGrid").string();
  CHECK(RunMotiondb(server.address(), {"segments", "export", "walks", "--out", grid}).exit_code ==
        0);
  CHECK(folder.Read("one.TextGrid") == folder.Read("grids/07_01.TextGrid"));
}

}  // namespace
}  // namespace motiondb::tests::segment_command_test
