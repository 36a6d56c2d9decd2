// motiondb update, list --filter, delete --filter and export --filter.
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/edit.pb.h>

#include <catch2/catch.hpp>

#include "tests/client/cli/ingest_answers.h"
#include "tests/client/fake_server.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"

namespace motiondb::tests::update_command_test {
namespace {

using Catch::Contains;
using Catch::StartsWith;

constexpr int kAborted = 10;

v1::Clip ClipNamed(const std::string& name, const std::string& etag) {
  v1::Clip clip;
  clip.set_name("databases/walks/clips/" + name);
  clip.set_file_name(name + ".bvh");
  clip.set_duration_seconds(4);
  clip.set_etag(etag);
  clip.add_tags("old");
  return clip;
}

void AnswerClip(FakeServer& server, const v1::Clip& clip) {
  v1::GetClipResponse response;
  *response.mutable_clip() = clip;
  server.Answer("GetClip", response);
}

v1::ListClipsResponse ListOf(const std::vector<v1::Clip>& clips) {
  v1::ListClipsResponse response;
  for (const v1::Clip& clip : clips) *response.add_clips() = clip;
  response.set_total_count(static_cast<int>(clips.size()));
  return response;
}

TEST_CASE("motiondb update: sends the given fields", "[client][cli]") {
  FakeServer server;
  v1::UpdateClipResponse response;
  response.set_revision(12);
  server.Answer("UpdateClip", response);
  const auto result = RunMotiondb(
      server.address(), {"update", "walks", "07_01", "--label", "jog", "--description", "",
                         "--field", "run:text=07", "--remove-field", "old", "--etag", "e1"});
  CHECK(result.err == "");
  CHECK(result.out == "updated clip 07_01; revision 12\n");
  const auto requests = server.Requests<v1::UpdateClipRequest>("UpdateClip");
  REQUIRE(requests.size() == 1);
  CHECK(requests[0].clip().name() == "databases/walks/clips/07_01");
  CHECK(requests[0].clip().etag() == "e1");
  CHECK(requests[0].clip().fields().at("run").text() == "07");
  CHECK(requests[0].update_mask().paths_size() == 4);
  CHECK(server.Requests<v1::GetClipRequest>("GetClip").empty());
}

TEST_CASE("motiondb update: adds tags to the stored ones, also after another writer's change",
          "[client][cli]") {
  FakeServer server;
  AnswerClip(server, ClipNamed("07_01", "e1"));
  v1::Clip changed = ClipNamed("07_01", "e2");
  changed.add_tags("other");
  AnswerClip(server, changed);
  server.Fail("UpdateClip", kAborted, "the etag is not the stored one");
  server.Answer("UpdateClip", v1::UpdateClipResponse());
  const auto result = RunMotiondb(
      server.address(), {"update", "walks", "07_01", "--tag", "new", "--remove-tag", "old"});
  CHECK(result.exit_code == 0);
  const auto requests = server.Requests<v1::UpdateClipRequest>("UpdateClip");
  REQUIRE(requests.size() == 2);
  CHECK(requests[0].clip().etag() == "e1");
  CHECK(requests[1].clip().etag() == "e2");
  REQUIRE(requests[1].clip().tags_size() == 2);
  CHECK(requests[1].clip().tags(0) == "new");
  CHECK(requests[1].clip().tags(1) == "other");
}

TEST_CASE("motiondb update: a given etag is not retried; other writers stop it in the end",
          "[client][cli]") {
  FakeServer server;
  AnswerClip(server, ClipNamed("07_01", "e1"));
  server.Fail("UpdateClip", kAborted, "the etag is not the stored one");
  const auto given =
      RunMotiondb(server.address(), {"update", "walks", "07_01", "--tag", "new", "--etag", "e0"});
  CHECK(given.exit_code == 1);
  CHECK(server.Requests<v1::UpdateClipRequest>("UpdateClip").size() == 1);
  CHECK(RunMotiondb(server.address(), {"update", "walks", "07_01", "--tag", "new"}).exit_code == 1);
  CHECK(server.Requests<v1::UpdateClipRequest>("UpdateClip").size() == 6);
}

TEST_CASE("motiondb update --filter: one transaction for 1,000 clips", "[client][cli]") {
  FakeServer server;
  std::vector<v1::Clip> clips;
  for (int i = 0; i < 1200; ++i) clips.push_back(ClipNamed(std::to_string(i), "e"));
  server.Answer("ListClips", ListOf(clips));
  v1::BatchEditResponse response;
  response.set_revision(5);
  server.Answer("BatchEdit", response);
  const std::vector<std::string> command = {"update",           "walks", "--filter",
                                            "subject = \"07\"", "--tag", "checked"};
  const auto result = RunMotiondb(server.address(), command);
  CHECK(result.out == "updated 1200 clips; revision 5\n");
  const auto batches = server.Requests<v1::BatchEditRequest>("BatchEdit");
  REQUIRE(batches.size() == 2);
  CHECK(batches[0].parent() == "databases/walks");
  CHECK(batches[0].changes_size() == 1000);
  CHECK(batches[1].changes_size() == 200);
  CHECK(batches[1].changes(0).update_clip().clip().name() == "databases/walks/clips/1000");
  CHECK(server.Requests<v1::ListClipsRequest>("ListClips")[0].filter() == "subject = \"07\"");
  auto dry = command;
  dry.emplace_back("--dry-run");
  CHECK(RunMotiondb(server.address(), dry).out == "would update 1200 clips\n");
  CHECK(server.Requests<v1::BatchEditRequest>("BatchEdit").size() == 2);
}

TEST_CASE("motiondb update --filter: reads the clips again after another writer's change",
          "[client][cli]") {
  FakeServer server;
  server.Answer("ListClips", ListOf({ClipNamed("a", "e1")}));
  AnswerClip(server, ClipNamed("a", "e2"));
  server.Fail("BatchEdit", kAborted, "changes[0].update_clip: the etag is not the stored one");
  server.Answer("BatchEdit", v1::BatchEditResponse());
  const auto result =
      RunMotiondb(server.address(), {"update", "walks", "--filter", "x", "--tag", "new"});
  CHECK(result.exit_code == 0);
  const auto batches = server.Requests<v1::BatchEditRequest>("BatchEdit");
  REQUIRE(batches.size() == 2);
  CHECK(batches[1].changes(0).update_clip().clip().etag() == "e2");
}

TEST_CASE("motiondb update: wrong usage", "[client][cli]") {
  const std::vector<std::vector<std::string>> wrong = {
      {"update", "walks", "--label", "a"},
      {"update", "walks", "07_01"},
      {"update", "walks", "07_01", "--filter", "x", "--label", "a"},
      {"update", "walks", "--filter", "", "--label", "a"},
      {"update", "walks", "--filter", "x", "--label", "a", "--etag", "e"},
      {"update", "walks", "07_01", "--label", "a", "--dry-run"},
      {"update", "walks", "07_01", "--field", "weight"},
      {"update", "walks", "07_01", "--field", "a:number=x"},
      {"list", "--filter", "x"},
      {"list", "walks", "--facets", "label", "--order-by", "name"},
      {"delete", "walks", "--filter", " "},
      {"delete", "walks", "07_01", "--filter", "x"},
      {"export", "walks"},
      {"export", "walks", "07_01", "--filter", "x"}};
  for (const auto& arguments : wrong) {
    CAPTURE(arguments);
    const auto result = RunMotiondb("", arguments);
    CHECK(result.exit_code == 2);
    CHECK_THAT(result.err, StartsWith("motiondb: ") && Contains(" --help`"));
  }
}

TEST_CASE("motiondb list: filter, order, titles and tags", "[client][cli]") {
  FakeServer server;
  v1::Clip titled = ClipNamed("a", "e");
  titled.set_title("A slow walk");
  server.Answer("ListClips", ListOf({titled, ClipNamed("b", "e")}));
  const auto result = RunMotiondb(
      server.address(), {"list", "walks", "--filter", "f", "--order-by", "duration desc"});
  CHECK_THAT(result.out,
             Contains("TITLE") && Contains("A slow walk") && Contains("TAGS") && Contains("old"));
  const auto requests = server.Requests<v1::ListClipsRequest>("ListClips");
  CHECK(requests[0].filter() == "f");
  CHECK(requests[0].order_by() == "duration desc");
}

TEST_CASE("motiondb list --facets: counts instead of clips", "[client][cli]") {
  FakeServer server;
  v1::ListClipsResponse response = ListOf({ClipNamed("a", "e")});
  v1::Facet& facet = *response.add_facets();
  facet.set_field("label");
  facet.add_values()->set_value("walk");
  facet.mutable_values(0)->set_clip_count(7);
  server.Answer("ListClips", response);
  const auto result = RunMotiondb(server.address(), {"list", "walks", "--facets", "label,tags"});
  CHECK(result.out == "FIELD  VALUE  CLIPS\nlabel  walk       7\n");
  CHECK_THAT(RunMotiondb(server.address(), {"list", "walks", "--facets", "label", "--json"}).out,
             StartsWith("{\"field\":\"label\""));
  const auto requests = server.Requests<v1::ListClipsRequest>("ListClips");
  CHECK(requests[0].facets_size() == 2);
}

TEST_CASE("motiondb delete --filter: deletes the clips and waits for the last rebuild",
          "[client][cli]") {
  FakeServer server;
  ServeDatabase(server);
  server.Answer("ListClips",
                ListOf({ClipNamed("a", "e"), ClipNamed("b", "e"), ClipNamed("c", "e")}));
  v1::DeleteClipResponse deleted;
  deleted.mutable_operation()->set_name("operations/4");
  server.Answer("DeleteClip", deleted);
  server.Fail("DeleteClip", 5, "clip 'b' does not exist");
  deleted.mutable_operation()->set_name("operations/5");
  server.Answer("DeleteClip", deleted);
  const std::vector<std::string> command = {"delete", "walks", "--filter", "f"};
  auto dry = command;
  dry.emplace_back("--dry-run");
  CHECK(RunMotiondb(server.address(), dry).out == "would delete 3 clips\n");
  ProgramTerminal refuses{.input = true, .typed = "no\n"};
  const auto refused = RunMotiondb(server.address(), command, refuses);
  CHECK(refused.exit_code == 1);
  CHECK_THAT(refused.err, Contains("This deletes 3 clips of walks. Type walks to continue"));
  CHECK(server.Requests<v1::DeleteClipRequest>("DeleteClip").empty());
  const auto result = RunMotiondb(server.address(), command);
  CHECK_THAT(result.out, StartsWith("deleted 2 clips; model 3: "));
  CHECK(server.Requests<v1::DeleteClipRequest>("DeleteClip").size() == 3);
}

TEST_CASE("motiondb export --filter: clips with the same file name get folders", "[client][cli]") {
  FakeServer server;
  v1::Clip same = ClipNamed("b", "e");
  same.set_file_name("a.bvh");
  server.Answer("ListClips", ListOf({ClipNamed("a", "e"), same, ClipNamed("c", "e")}));
  for (const char* file : {"a.bvh", "a.bvh", "c.bvh"}) {
    v1::ExportClipResponse header, block;
    header.mutable_header()->set_file_name(file);
    block.set_file_block("motion");
    server.Answer("ExportClip", header, block);
  }
  const TemporaryFolder folder;
  const auto result = RunMotiondb(
      server.address(), {"export", "walks", "--filter", "f", "--out", folder.path().string()});
  CHECK(result.err == "");
  CHECK(folder.Read("a/a.bvh") == "motion");
  CHECK(folder.Read("b/a.bvh") == "motion");
  CHECK(folder.Read("c.bvh") == "motion");
}

}  // namespace
}  // namespace motiondb::tests::update_command_test
