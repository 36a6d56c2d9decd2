// motiondb history, undo and search.
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/edit.pb.h>

#include <catch2/catch.hpp>

#include "tests/client/fake_server.h"
#include "tests/client/run_motiondb.h"

namespace motiondb::tests::history_command_test {
namespace {

using Catch::Contains;
using Catch::StartsWith;

v1::Edit Relabelled() {
  v1::Edit edit;
  edit.set_name("databases/walks/edits/17");
  edit.set_author("tokens/1f");
  edit.mutable_create_time()->set_seconds(1'000);
  v1::EditedObject& clip = *edit.add_objects();
  clip.set_name("databases/walks/clips/07_01");
  clip.mutable_clip_before()->set_label("walk");
  clip.mutable_clip_after()->set_label("jog");
  clip.mutable_clip_after()->add_tags("fast");
  v1::EditedObject& segment = *edit.add_objects();
  segment.set_name("databases/walks/clips/07_01/segments/a");
  segment.mutable_segment_after()->set_label("box");
  segment.mutable_segment_after()->set_track("carries");
  segment.mutable_segment_after()->set_end_seconds(1.5);
  return edit;
}

TEST_CASE("motiondb history: says what changed", "[client][cli]") {
  FakeServer server;
  v1::ListEditsResponse response;
  *response.add_edits() = Relabelled();
  response.set_next_page_token("more");
  server.Answer("ListEdits", response);
  const auto result = RunMotiondb(server.address(), {"history", "walks", "07_01", "--top", "1"});
  CHECK_THAT(result.out, StartsWith("EDIT") && Contains("17") && Contains("1970-01-01T00:16:40Z") &&
                             Contains("07_01: label 'walk' -> 'jog', tags '' -> 'fast'; 07_01/a: "
                                      "new, carries 0.00-1.50 s 'box'"));
  const auto requests = server.Requests<v1::ListEditsRequest>("ListEdits");
  REQUIRE(requests.size() == 1);
  CHECK(requests[0].clip() == "databases/walks/clips/07_01");
  CHECK(requests[0].page_size() == 1);
}

TEST_CASE("motiondb undo: restores an edit", "[client][cli]") {
  FakeServer server;
  v1::UndoEditResponse response;
  *response.mutable_edit() = Relabelled();
  response.mutable_edit()->set_name("databases/walks/edits/18");
  response.set_revision(30);
  server.Answer("UndoEdit", response);
  const auto result = RunMotiondb(server.address(), {"undo", "walks", "17"});
  CHECK_THAT(result.out, StartsWith("undone by edit 18; revision 30\n  07_01: label"));
  CHECK(server.Requests<v1::UndoEditRequest>("UndoEdit")[0].name() == "databases/walks/edits/17");
}

TEST_CASE("motiondb search: sends the words; reads pages up to --top", "[client][cli]") {
  FakeServer server;
  v1::SearchClipsResponse response;
  v1::ClipMatch& match = *response.add_matches();
  match.mutable_clip()->set_name("databases/walks/clips/07_01");
  match.mutable_clip()->set_label("walk");
  match.set_score(2.5);
  response.set_total_count(57);
  response.set_next_page_token("2");
  server.Answer("SearchClips", response);
  const auto result = RunMotiondb(
      server.address(), {"search", "walks", "slow", "wal*", "--filter", "f", "--top", "2"});
  CHECK_THAT(result.out, Contains("SCORE") && Contains("07_01") && Contains("2.50") &&
                             Contains("2 of 57 clips; --top K prints more\n"));
  const auto requests = server.Requests<v1::SearchClipsRequest>("SearchClips");
  REQUIRE(requests.size() == 2);
  CHECK(requests[0].query() == "slow wal*");
  CHECK(requests[0].filter() == "f");
  CHECK(requests[1].page_token() == "2");
  CHECK(RunMotiondb(server.address(), {"search", "walks"}).exit_code == 2);
}

}  // namespace
}  // namespace motiondb::tests::history_command_test
