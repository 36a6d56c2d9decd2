// UpdateClip, SegmentService, EditService and SearchClips of a real server.
#include <google/protobuf/util/message_differencer.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/edit.grpc.pb.h"
#include "motiondb/v1/segment.grpc.pb.h"
#include "tests/server/rpc/refusal.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::annotation_test {
namespace {

using google::protobuf::util::MessageDifferencer;
using Clips = v1::ClipService::Stub;
using Edits = v1::EditService::Stub;
using Segments = v1::SegmentService::Stub;

constexpr char kWalk[] = "databases/db/clips/walk";

// A server with the clips walk (1.5 s, label walking) and squat (squatting).
struct Annotated {
  TestServer server;
  std::unique_ptr<Clips> clips = server.NewStub<v1::ClipService>();
  std::unique_ptr<Segments> segments = server.NewStub<v1::SegmentService>();
  std::unique_ptr<Edits> edits = server.NewStub<v1::EditService>();

  Annotated() {
    server.CreateDatabase("db");
    server.IngestFigure("db", "walk", "walking", {.frame_count = 90});
    server.IngestFigure("db", "squat", "squatting", {.frame_count = 60, .phase = 1});
  }

  v1::Clip Get(const std::string& name = kWalk) {
    v1::GetClipRequest request;
    request.set_name(name);
    const auto got = Ask(*clips, &Clips::GetClip, request);
    REQUIRE(got.status.ok());
    return got.response.clip();
  }

  Answer<v1::UpdateClipResponse> Update(const v1::Clip& clip,
                                        const std::vector<std::string>& mask) {
    v1::UpdateClipRequest request;
    *request.mutable_clip() = clip;
    for (const std::string& path : mask) request.mutable_update_mask()->add_paths(path);
    return Ask(*clips, &Clips::UpdateClip, request);
  }

  Answer<v1::CreateSegmentResponse> Create(const v1::CreateSegmentRequest& request) {
    return Ask(*segments, &Segments::CreateSegment, request);
  }

  std::vector<v1::Segment> List(const std::string& parent, const std::string& filter = "") {
    v1::ListSegmentsRequest request;
    request.set_parent(parent);
    request.set_filter(filter);
    const auto listed = Ask(*segments, &Segments::ListSegments, request);
    INFO(listed.status.error_message());
    REQUIRE(listed.status.ok());
    CHECK(listed.response.total_count() == listed.response.segments_size());
    return {listed.response.segments().begin(), listed.response.segments().end()};
  }
};

v1::CreateSegmentRequest NewSegment(const std::string& label, double start, double end,
                                    const std::string& track = "") {
  v1::CreateSegmentRequest request;
  request.set_parent(kWalk);
  request.mutable_segment()->set_label(label);
  request.mutable_segment()->set_start_seconds(start);
  request.mutable_segment()->set_end_seconds(end);
  request.mutable_segment()->set_track(track);
  return request;
}

TEST_CASE("UpdateClip: sets what the mask names, and nothing else", "[server][rpc]") {
  Annotated db;
  const v1::Clip before = db.Get();
  CHECK(before.label() == "walking");
  CHECK_FALSE(before.etag().empty());
  CHECK_FALSE(before.has_update_time());

  v1::Clip clip = before;
  clip.set_title("A slow walk");
  clip.set_description("Two lines:\nof text");
  for (const char* const tag : {"zoo", "indoor", "zoo"}) clip.add_tags(tag);
  (*clip.mutable_fields())["age"].set_number(31);
  (*clip.mutable_fields())["site"].set_text("lab 2");
  (*clip.mutable_fields())["old"].mutable_time()->set_seconds(-86'400);
  clip.set_subject("07");
  clip.set_label("strolling");
  const auto updated = db.Update(clip, {"title", "description", "tags", "fields"});
  REQUIRE(updated.status.ok());
  CHECK_FALSE(updated.response.has_operation());  // neither label nor subject
  const v1::Clip after = db.Get();
  CHECK(MessageDifferencer::Equals(after, updated.response.clip()));
  CHECK(after.title() == "A slow walk");
  CHECK(after.description() == "Two lines:\nof text");
  CHECK(std::vector<std::string>(after.tags().begin(), after.tags().end()) ==
        std::vector<std::string>{"indoor", "zoo"});
  CHECK(after.fields().at("age").number() == 31);
  CHECK(after.fields().at("old").time().seconds() == -86'400);
  CHECK(after.label() == "walking");
  CHECK(after.subject().empty());
  CHECK(after.has_update_time());
  CHECK(after.etag() != before.etag());

  v1::Clip one;
  one.set_name(kWalk);
  (*one.mutable_fields())["age"].set_number(32);
  REQUIRE(db.Update(one, {"fields.age", "fields.site"}).status.ok());
  CHECK(db.Get().fields().at("age").number() == 32);
  CHECK_FALSE(db.Get().fields().contains("site"));
  CHECK(db.Get().fields().contains("old"));

  const auto relabelled = db.Update(clip, {"label", "subject"});
  // The etag of `clip` is that of the first version.
  CHECK(relabelled.status.error_code() == grpc::StatusCode::ABORTED);
  clip.set_etag(db.Get().etag());
  const auto again = db.Update(clip, {"label", "subject"});
  REQUIRE(again.status.ok());
  CHECK(again.response.has_operation());
  CHECK(db.Get().label() == "strolling");
  CHECK(db.Get().subject() == "07");
  CHECK(db.List(kWalk).front().label() == "strolling");
}

TEST_CASE("UpdateClip: invalid values name their field and change nothing", "[server][rpc]") {
  Annotated db;
  const std::string before = db.Get().SerializeAsString();
  v1::Clip clip;
  clip.set_name(kWalk);
  CHECK(ViolatedFields(db.Update(clip, {}).status) == "update_mask");
  CHECK(ViolatedFields(db.Update(clip, {"frame_count"}).status) == "update_mask");
  CHECK(ViolatedFields(db.Update(clip, {"label"}).status) == "clip.label");
  clip.set_title(std::string(201, 'x'));
  CHECK(ViolatedFields(db.Update(clip, {"title"}).status) == "clip.title");
  clip.add_tags("Upper Case");
  CHECK(ViolatedFields(db.Update(clip, {"tags"}).status) == "clip.tags[0]");
  (*clip.mutable_fields())["n"].set_number(std::numeric_limits<double>::quiet_NaN());
  CHECK(ViolatedFields(db.Update(clip, {"fields"}).status) == "clip.fields[n]");
  clip.set_etag("new");
  CHECK(ViolatedFields(db.Update(clip, {"subject"}).status) == "clip.etag");
  clip.set_name("databases/db/clips/none");
  clip.clear_etag();
  CHECK(db.Update(clip, {"subject"}).status.error_code() == grpc::StatusCode::NOT_FOUND);
  CHECK(db.Get().SerializeAsString() == before);
}

TEST_CASE("Segments: a long take gets segments on tracks, which do not overlap", "[server][rpc]") {
  Annotated db;
  REQUIRE(db.List(kWalk).size() == 1);
  CHECK(db.List(kWalk)[0].label() == "walking");
  CHECK_FALSE(db.List(kWalk)[0].has_end_seconds());

  // The segment of the ingest's label gives way.
  const auto first = db.Create(NewSegment("step", 0, 0.5));
  INFO(first.status.error_message());
  REQUIRE(first.status.ok());
  CHECK(first.response.segment().track() == "action");
  CHECK(first.response.has_operation());
  CHECK(db.List(kWalk).size() == 1);
  CHECK(db.Get().label().empty());
  REQUIRE(db.Create(NewSegment("turn", 0.5, 1)).status.ok());
  REQUIRE(db.Create(NewSegment("box", 0.2, 1.2, "carries")).status.ok());
  const auto overlap = db.Create(NewSegment("hop", 0.9, 1.4));
  CHECK(overlap.status.error_code() == grpc::StatusCode::FAILED_PRECONDITION);
  CHECK(ReasonOf(overlap.status) == "SEGMENTS_OVERLAP");
  CHECK(db.List(kWalk).size() == 3);

  v1::CreateSegmentRequest named = NewSegment("rest", 1, 1.5);
  named.set_segment_id("rest-1");
  REQUIRE(db.Create(named).status.ok());
  CHECK(db.Create(named).status.error_code() == grpc::StatusCode::ALREADY_EXISTS);

  const auto walk = db.List(kWalk);
  REQUIRE(walk.size() == 4);
  CHECK(walk[0].label() == "step");
  CHECK(walk[1].label() == "turn");
  CHECK(walk[2].label() == "rest");
  CHECK(walk[3].label() == "box");
  CHECK(db.List("databases/db").size() == 5);
  CHECK(db.List("databases/db", "track = carries").size() == 1);

  // A label of the clip has no segment to change.
  v1::Clip clip;
  clip.set_name(kWalk);
  clip.set_label("all");
  CHECK(db.Update(clip, {"label"}).status.error_code() == grpc::StatusCode::FAILED_PRECONDITION);

  v1::UpdateSegmentRequest move;
  *move.mutable_segment() = walk[1];
  move.mutable_segment()->set_end_seconds(0.9);
  move.mutable_update_mask()->add_paths("end_seconds");
  const auto moved = Ask(*db.segments, &Segments::UpdateSegment, move);
  REQUIRE(moved.status.ok());
  CHECK(moved.response.segment().end_seconds() == 0.9);
  CHECK(Ask(*db.segments, &Segments::UpdateSegment, move).status.error_code() ==
        grpc::StatusCode::ABORTED);  // the etag is old

  v1::DeleteSegmentRequest remove;
  remove.set_name(walk[1].name());
  remove.set_etag(walk[1].etag());
  CHECK(Ask(*db.segments, &Segments::DeleteSegment, remove).status.error_code() ==
        grpc::StatusCode::ABORTED);
  remove.clear_etag();
  CHECK(Ask(*db.segments, &Segments::DeleteSegment, remove).status.ok());
  CHECK(Ask(*db.segments, &Segments::DeleteSegment, remove).status.error_code() ==
        grpc::StatusCode::NOT_FOUND);
}

TEST_CASE("Segments: invalid ranges are refused", "[server][rpc]") {
  Annotated db;
  CHECK(ViolatedFields(db.Create(NewSegment("", 0, 1)).status) == "segment.label");
  CHECK(ViolatedFields(db.Create(NewSegment("a", 1, 1)).status) == "segment.end_seconds");
  CHECK(ViolatedFields(db.Create(NewSegment("a", -1, 1)).status) == "segment.start_seconds");
  CHECK(ViolatedFields(db.Create(NewSegment("a", 0, 1, "No")).status) == "segment.track");
  CHECK(db.Create(NewSegment("a", 0, 9)).status.error_code() == grpc::StatusCode::INVALID_ARGUMENT);
  CHECK(db.List(kWalk).size() == 1);
}

TEST_CASE("BatchEdit: all changes or none, with history and undo", "[server][rpc]") {
  Annotated db;
  v1::BatchEditRequest batch;
  batch.set_parent("databases/db");
  *batch.add_changes()->mutable_create_segment() = NewSegment("step", 0, 0.5);
  v1::UpdateClipRequest& update = *batch.add_changes()->mutable_update_clip();
  update.mutable_clip()->set_name("databases/db/clips/squat");
  update.mutable_clip()->set_title("Squat");
  update.mutable_update_mask()->add_paths("title");
  *batch.add_changes()->mutable_create_segment() = NewSegment("hop", 0.4, 1);
  const auto failed = Ask(*db.edits, &Edits::BatchEdit, batch);
  CHECK(failed.status.error_code() == grpc::StatusCode::FAILED_PRECONDITION);
  CHECK(failed.status.error_message().find("changes[2]") != std::string::npos);
  CHECK(db.List(kWalk).front().label() == "walking");
  CHECK(db.Get("databases/db/clips/squat").title().empty());

  batch.mutable_changes(2)->mutable_create_segment()->mutable_segment()->set_start_seconds(0.5);
  const auto edited = Ask(*db.edits, &Edits::BatchEdit, batch);
  REQUIRE(edited.status.ok());
  CHECK(edited.response.has_operation());
  CHECK(edited.response.edit().author() == "anonymous");
  CHECK(db.List(kWalk).size() == 2);

  v1::UndoEditRequest undo;
  undo.set_name(edited.response.edit().name());
  const auto undone = Ask(*db.edits, &Edits::UndoEdit, undo);
  REQUIRE(undone.status.ok());
  REQUIRE(db.List(kWalk).size() == 1);
  CHECK(db.List(kWalk).front().label() == "walking");
  CHECK(db.Get("databases/db/clips/squat").title().empty());
  undo.set_name(undone.response.edit().name());
  REQUIRE(Ask(*db.edits, &Edits::UndoEdit, undo).status.ok());
  CHECK(db.List(kWalk).size() == 2);
  CHECK(db.Get("databases/db/clips/squat").title() == "Squat");
  // An object is no longer in the state after the edit.
  update.mutable_clip()->set_title("Deep squat");
  REQUIRE(db.Update(update.clip(), {"title"}).status.ok());
  undo.set_name(edited.response.edit().name());
  CHECK(Ask(*db.edits, &Edits::UndoEdit, undo).status.error_code() == grpc::StatusCode::ABORTED);

  v1::ListEditsRequest history;
  history.set_parent("databases/db");
  history.set_page_size(2);
  const auto newest = Ask(*db.edits, &Edits::ListEdits, history);
  REQUIRE(newest.status.ok());
  REQUIRE(newest.response.edits_size() == 2);
  history.set_page_size(100);
  history.set_page_token(newest.response.next_page_token());
  const auto rest = Ask(*db.edits, &Edits::ListEdits, history);
  REQUIRE(rest.response.edits_size() == 2);
  CHECK(rest.response.edits(1).name() == edited.response.edit().name());
  CHECK(rest.response.next_page_token().empty());
  history.clear_page_token();
  history.set_clip("databases/db/clips/squat");
  CHECK(Ask(*db.edits, &Edits::ListEdits, history).response.edits_size() == 4);
}

TEST_CASE("ListEdits: pages of any size have each edit once, newest first", "[server][rpc]") {
  Annotated db;
  v1::Clip clip;
  clip.set_name(kWalk);
  std::vector<std::string> newest_first;
  for (int i = 0; i < 20; ++i) {
    clip.set_title("title " + std::to_string(i));
    const auto updated = db.Update(clip, {"title"});
    newest_first.insert(newest_first.begin(),
                        "databases/db/edits/" + std::to_string(updated.response.revision()));
  }
  for (const int size : {1, 7, 8, 16, 20, 1000}) {
    v1::ListEditsRequest request;
    request.set_parent("databases/db");
    request.set_page_size(size);
    std::vector<std::string> names;
    do {
      const auto page = Ask(*db.edits, &Edits::ListEdits, request);
      REQUIRE(page.response.edits_size() <= size);
      for (const v1::Edit& edit : page.response.edits()) names.push_back(edit.name());
      request.set_page_token(page.response.next_page_token());
    } while (!request.page_token().empty());
    CHECK(names == newest_first);
  }
}

TEST_CASE("ListClips: filters, sorts, counts and pages", "[server][rpc]") {
  Annotated db;
  v1::Clip clip;
  clip.set_name(kWalk);
  clip.add_tags("indoor");
  REQUIRE(db.Update(clip, {"tags"}).status.ok());
  v1::ListClipsRequest request;
  request.set_parent("databases/db");
  request.set_filter("tags:indoor");
  const auto indoor = Ask(*db.clips, &Clips::ListClips, request);
  REQUIRE(indoor.status.ok());
  REQUIRE(indoor.response.clips_size() == 1);
  CHECK(indoor.response.clips(0).SerializeAsString() == db.Get().SerializeAsString());
  CHECK(indoor.response.total_count() == 1);

  request.set_filter("duration > 0.5s");
  request.set_order_by("duration desc");
  request.set_page_size(1);
  request.add_facets("label");
  const auto longest = Ask(*db.clips, &Clips::ListClips, request);
  REQUIRE(longest.status.ok());
  CHECK(longest.response.clips(0).name() == kWalk);
  CHECK(longest.response.total_count() == 2);
  REQUIRE(longest.response.facets_size() == 1);
  CHECK(longest.response.facets(0).values_size() == 2);
  request.set_page_token(longest.response.next_page_token());
  const auto shorter = Ask(*db.clips, &Clips::ListClips, request);
  REQUIRE(shorter.response.clips_size() == 1);
  CHECK(shorter.response.clips(0).name() == "databases/db/clips/squat");
  CHECK(shorter.response.next_page_token().empty());

  request.clear_page_token();
  request.set_filter("duraton > 1");
  const auto misspelled = Ask(*db.clips, &Clips::ListClips, request);
  CHECK(ViolatedFields(misspelled.status) == "filter");
  CHECK(misspelled.status.error_message().find("duration") != std::string::npos);
  request.clear_filter();
  request.set_order_by("nothing");
  CHECK(ViolatedFields(Ask(*db.clips, &Clips::ListClips, request).status) == "order_by");
}

TEST_CASE("SearchClips: words of titles, labels and file names", "[server][rpc]") {
  Annotated db;
  v1::Clip clip;
  clip.set_name(kWalk);
  clip.set_title("Slow stroll, café");
  REQUIRE(db.Update(clip, {"title"}).status.ok());
  v1::SearchClipsRequest request;
  request.set_parent("databases/db");
  const auto count = [&](const std::string& query, const std::string& filter = "") {
    request.set_query(query);
    request.set_filter(filter);
    const auto found = Ask(*db.clips, &Clips::SearchClips, request);
    INFO(query << ": " << found.status.error_message());
    REQUIRE(found.status.ok());
    CHECK(found.response.total_count() == found.response.matches_size());
    return found.response.matches_size();
  };
  CHECK(count("CAFE") == 1);
  CHECK(count("\"slow stroll\"") == 1);
  CHECK(count("\"stroll slow\"") == 0);
  CHECK(count("walk*") == 1);
  CHECK(count("squat*") == 1);
  CHECK(count("bvh") == 2);
  CHECK(count("bvh", "label = squatting") == 1);
  // The values of all matches are counted, not only those of the page, and of no other clip.
  request.add_facets("label");
  request.set_page_size(1);
  const auto labels = [&](const std::string& query, const std::string& filter) {
    request.set_query(query);
    request.set_filter(filter);
    const auto found = Ask(*db.clips, &Clips::SearchClips, request);
    REQUIRE(found.response.facets_size() == 1);
    std::string text;
    for (const v1::FacetValue& value : found.response.facets(0).values()) {
      text += value.value() + " " + std::to_string(value.clip_count()) + ";";
    }
    return text;
  };
  CHECK(labels("bvh", "") == "squatting 1;walking 1;");
  CHECK(labels("bvh", "label = squatting") == "squatting 1;");
  CHECK(labels("cafe", "") == "walking 1;");
  request.add_facets("nothing");
  CHECK(ViolatedFields(Ask(*db.clips, &Clips::SearchClips, request).status) == "facets");
  request.clear_facets();
  request.set_query("");
  CHECK(ViolatedFields(Ask(*db.clips, &Clips::SearchClips, request).status) == "query");
}

}  // namespace
}  // namespace motiondb::tests::annotation_test
