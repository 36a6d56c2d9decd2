// UploadClip: the same result as IngestClip, and the points of a file. Also titles, descriptions,
// tags and fields of both.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <string>

#include "core/motion/marker_set.h"
#include "motiondb/v1/access.grpc.pb.h"
#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/marker_set.grpc.pb.h"
#include "tests/server/rpc/refusal.h"
#include "tests/support/humanoid_bvh.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::upload_test {
namespace {

using grpc::StatusCode;
using Stub = v1::ClipService::Stub;

v1::UploadClipRequest Upload(const std::string& database, const std::string& file_name,
                             const std::string& file = WriteBvh({})) {
  v1::UploadClipRequest request;
  request.mutable_header()->set_parent("databases/" + database);
  request.mutable_header()->set_file_name(file_name);
  request.set_file(file);
  return request;
}

Answer<v1::UploadClipResponse> Send(TestServer& server, const v1::UploadClipRequest& request,
                                    const std::string& token = "") {
  return Ask(*server.NewStub<v1::ClipService>(), &Stub::UploadClip, request, token);
}

v1::UploadClipResponse Uploaded(TestServer& server, const v1::UploadClipRequest& request) {
  const auto answer = Send(server, request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  return answer.response;
}

void AddAnnotations(v1::IngestClipHeader& header) {
  header.set_label("walk");
  header.set_subject("07");
  header.set_title("A slow walk");
  header.set_description("Two\nlines");
  header.add_tags("outdoor");
  header.add_tags("checked");
  header.add_tags("outdoor");
  (*header.mutable_fields())["weight"].set_number(72.5);
  (*header.mutable_fields())["run"].set_text("07");
}

void CreateStandard(TestServer& server, const std::string& id) {
  v1::CreateDatabaseRequest request;
  request.set_database_id(id);
  const auto stub = server.NewStub<v1::DatabaseService>();
  REQUIRE(Ask(*stub, &v1::DatabaseService::Stub::CreateDatabase, request).status.ok());
}

int StoredClips(TestServer& server, const std::string& database) {
  return server.Describe(database).stored_clip_count();
}

}  // namespace

TEST_CASE("UploadClip: stores the clip that IngestClip stores", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("one");
  server.CreateDatabase("two");
  v1::UploadClipRequest request = Upload("one", "walk.bvh");
  AddAnnotations(*request.mutable_header());
  v1::UploadClipResponse uploaded = Uploaded(server, request);
  v1::IngestClipHeader header = request.header();
  header.set_parent("databases/two");
  v1::IngestClipResponse ingested;
  REQUIRE(server.Ingest(header, request.file(), &ingested).ok());

  v1::Clip clip = uploaded.clip();
  CHECK(clip.name() == "databases/one/clips/walk");
  CHECK(clip.title() == "A slow walk");
  CHECK(clip.description() == "Two\nlines");
  CHECK(std::vector<std::string>(clip.tags().begin(), clip.tags().end()) ==
        std::vector<std::string>{"checked", "outdoor"});
  CHECK(clip.fields().at("weight").number() == 72.5);
  CHECK(clip.fields().at("run").text() == "07");
  CHECK(clip.label() == "walk");
  CHECK(uploaded.points().empty());
  v1::Clip expected = ingested.clip();
  for (v1::Clip* const each : {&clip, &expected}) {
    each->clear_name();
    each->clear_skeleton();
    each->clear_create_time();
  }
  // Fields are a map: its serialized order is not fixed.
  CHECK(clip.fields_size() == expected.fields_size());
  clip.clear_fields();
  expected.clear_fields();
  CHECK(clip.SerializeAsString() == expected.SerializeAsString());
  CHECK(server.Wait(uploaded.operation().name()).state() == v1::OPERATION_STATE_SUCCEEDED);

  // They are found by filters, and part of the search.
  v1::ListClipsRequest list;
  list.set_parent("databases/one");
  list.set_filter("tags:outdoor AND fields.weight > 70 AND fields.run = \"07\"");
  const auto stub = server.NewStub<v1::ClipService>();
  CHECK(Ask(*stub, &Stub::ListClips, list).response.total_count() == 1);
  v1::SearchClipsRequest search;
  search.set_parent("databases/one");
  search.set_query("slow");
  CHECK(Ask(*stub, &Stub::SearchClips, search).response.total_count() == 1);
}

TEST_CASE("UploadClip: a replaced clip keeps what the new one does not have", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  v1::UploadClipRequest request = Upload("db", "walk.bvh");
  AddAnnotations(*request.mutable_header());
  Uploaded(server, request);

  v1::UploadClipRequest again = Upload("db", "walk.bvh");
  again.mutable_header()->set_replace(true);
  again.mutable_header()->set_title("Another title");
  const bool validate_only = GENERATE(true, false);
  again.mutable_header()->set_validate_only(validate_only);
  const v1::Clip clip = Uploaded(server, again).clip();
  CHECK(clip.name() == "databases/db/clips/walk");
  CHECK(clip.title() == "Another title");
  CHECK(clip.description() == "Two\nlines");
  CHECK(clip.tags_size() == 2);
  CHECK(clip.fields_size() == 2);
  CHECK(clip.label() == "walk");
  CHECK(clip.subject() == "07");
}

TEST_CASE("UploadClip: the error names the field", "[server][rpc]") {
  server::ServerOptions options;
  options.engine.max_file_bytes = 200'000;
  TestServer server(options);
  server.CreateDatabase("db");
  const auto expect = [&](const std::string& field, const auto& change,
                          StatusCode code = StatusCode::INVALID_ARGUMENT) {
    v1::UploadClipRequest request = Upload("db", "walk.bvh");
    change(request);
    const auto answer = Send(server, request);
    INFO(field << ": " << answer.status.error_message());
    CHECK(answer.status.error_code() == code);
    CHECK(ViolatedFields(answer.status) == field);
  };
  const auto header = [&](const std::string& field, const auto& change) {
    expect("header." + field, [&](auto& request) { change(*request.mutable_header()); });
  };
  header("parent", [](auto& to) { to.clear_parent(); });
  header("file_name", [](auto& to) { to.clear_file_name(); });
  header("title", [](auto& to) { to.set_title(std::string(201, 'x')); });
  header("title", [](auto& to) { to.set_title("two\nlines"); });
  header("description", [](auto& to) { to.set_description(std::string(4001, 'x')); });
  header("tags[1]", [](auto& to) {
    to.add_tags("good");
    to.add_tags("Not good");
  });
  header("tags", [](auto& to) {
    for (int i = 0; i < 65; ++i) to.add_tags("t" + std::to_string(i));
  });
  header("fields[Weight]", [](auto& to) { (*to.mutable_fields())["Weight"].set_number(1); });
  header("fields[weight]", [](auto& to) { (*to.mutable_fields())["weight"].set_number(NAN); });
  header("fields[weight]", [](auto& to) { (*to.mutable_fields())["weight"]; });
  header("fields", [](auto& to) {
    for (int i = 0; i < 65; ++i) (*to.mutable_fields())["f" + std::to_string(i)].set_flag(true);
  });
  expect("header.parent", [](auto& request) { request.clear_header(); });
  expect("file", [](auto& request) { request.clear_file(); });
  expect("file", [](auto& request) { request.set_file("HIERARCHY\ngarbage"); });
  expect("file", [](auto& request) { request.set_file(std::string(1000, '\0')); });
  expect("skeleton_file", [](auto& request) { request.set_skeleton_file("x"); });
  expect("skeleton_file", [](auto& request) {
    request.mutable_header()->set_file_name("walk.amc");
    request.mutable_header()->set_skeleton_file_name("walk.asf");
  });
  expect(
      "", [](auto& request) { request.set_file(WriteBvh({.frame_count = 2000})); },
      StatusCode::RESOURCE_EXHAUSTED);
  expect(
      "", [](auto& request) { request.mutable_header()->set_parent("databases/none"); },
      StatusCode::NOT_FOUND);
  CHECK(StoredClips(server, "db") == 0);
}

TEST_CASE("UploadClip: IngestClip names the same fields", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  v1::IngestClipHeader header = Upload("db", "walk.bvh").header();
  header.add_tags("Not good");
  const grpc::Status refused = server.Ingest(header, WriteBvh({}));
  CHECK(refused.error_code() == StatusCode::INVALID_ARGUMENT);
  CHECK(ViolatedFields(refused) == "header.tags[0]");
}

TEST_CASE("UploadClip: the same motion, quotas and large messages", "[server][rpc]") {
  server::ServerOptions options;
  options.engine.quota.clip_count = 2;
  options.max_message_bytes = 300'000;
  TestServer server(options);
  server.CreateDatabase("db");
  Uploaded(server, Upload("db", "walk.bvh"));
  CHECK(Send(server, Upload("db", "again.bvh")).status.error_code() == StatusCode::ALREADY_EXISTS);
  Uploaded(server, Upload("db", "other.bvh", WriteBvh({.phase = 0.5})));
  const auto third = Send(server, Upload("db", "third.bvh", WriteBvh({.phase = 1.0})));
  CHECK(third.status.error_code() == StatusCode::RESOURCE_EXHAUSTED);
  CHECK(ReasonOf(third.status) == "QUOTA_EXCEEDED");
  const auto large = Send(server, Upload("db", "large.bvh", std::string(400'000, 'x')));
  CHECK(large.status.error_code() == StatusCode::RESOURCE_EXHAUSTED);
  CHECK(StoredClips(server, "db") == 2);
}

TEST_CASE("UploadClip: the points of the file and the markers that they become", "[server][rpc]") {
  TestServer server;
  CreateStandard(server, "db");
  v1::UploadClipRequest request = Upload("db", "walk.bvh", HumanoidBvh(100, 60));
  request.mutable_header()->set_validate_only(true);
  const v1::UploadClipResponse checked = Uploaded(server, request);
  CHECK(checked.operation().name().empty());
  CHECK(!checked.mapping().empty());
  CHECK_THAT(checked.mapping_text(), Catch::Contains("LKnee = 1 LeftLeg\n"));
  CHECK(StoredClips(server, "db") == 0);

  REQUIRE(!checked.points().empty());
  CHECK(!checked.points(0).has_parent_point());
  std::set<std::string> markers;
  for (int i = 0; i < checked.points_size(); ++i) {
    const v1::SourcePoint& point = checked.points(i);
    INFO(point.name());
    CHECK(!point.name().empty());
    if (point.has_parent_point()) CHECK(point.parent_point() < i);
    CHECK(std::abs(point.x_m()) < 10);
    CHECK(point.z_m() > -0.2);
    CHECK(point.z_m() < 2.5);
    markers.insert(point.marker_names().begin(), point.marker_names().end());
  }
  v1::GetMarkerSetRequest of_database;
  of_database.set_database("databases/db");
  const auto set = Ask(*server.NewStub<v1::MarkerSetService>(),
                       &v1::MarkerSetService::Stub::GetMarkerSet, of_database);
  REQUIRE(set.status.ok());
  // Every marker that is mapped is one of the set; a figure has most of them.
  CHECK(markers.size() >= 20);
  CHECK(markers.contains("LKnee"));
  const auto knee = std::ranges::find_if(checked.points(), [](const v1::SourcePoint& point) {
    return std::ranges::find(point.marker_names(), "LKnee") != point.marker_names().end();
  });
  REQUIRE(knee != checked.points().end());
  CHECK(knee->z_m() == Approx(0.5).margin(0.2));
}

TEST_CASE("UploadClip: a marker set of the file's own points has no mapping", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  v1::UploadClipRequest request = Upload("db", "walk.bvh");
  request.mutable_header()->set_validate_only(true);
  const v1::UploadClipResponse checked = Uploaded(server, request);
  CHECK(checked.mapping().empty());
  int used = 0;
  for (const v1::SourcePoint& point : checked.points()) {
    REQUIRE(point.marker_names_size() <= 1);
    if (point.marker_names().empty()) continue;
    CHECK(point.marker_names(0) == point.name());
    ++used;
  }
  CHECK(used == 10);
}

TEST_CASE("UploadClip: needs the role of ingests; is in the audit log", "[server][rpc][security]") {
  TestServer server;
  server.CreateDatabase("db");
  server.CreateDatabase("other");
  const auto token = [&](v1::Role role, const std::string& database = "") {
    v1::CreateTokenRequest request;
    request.mutable_token()->set_role(role);
    request.mutable_token()->set_database(database);
    const auto made =
        Ask(*server.NewStub<v1::AccessService>(), &v1::AccessService::Stub::CreateToken, request);
    REQUIRE(made.status.ok());
    return made.response.secret();
  };
  const std::string reader = token(v1::ROLE_READER);
  const std::string ingester = token(v1::ROLE_INGESTER, "databases/db");
  const std::string admin = token(v1::ROLE_ADMIN);
  server.options().security.authentication = server::Authentication::kToken;
  server.Restart();
  const auto code = [&](const v1::UploadClipRequest& request, const std::string& by) {
    return Send(server, request, by).status.error_code();
  };
  CHECK(code(Upload("db", "walk.bvh"), "") == StatusCode::UNAUTHENTICATED);
  CHECK(code(Upload("db", "walk.bvh"), reader) == StatusCode::PERMISSION_DENIED);
  CHECK(code(Upload("other", "walk.bvh"), ingester) == StatusCode::PERMISSION_DENIED);
  v1::UploadClipRequest check = Upload("db", "walk.bvh");
  check.mutable_header()->set_validate_only(true);
  CHECK(code(check, ingester) == StatusCode::OK);
  CHECK(code(Upload("db", "walk.bvh"), ingester) == StatusCode::OK);

  const auto audit = Ask(*server.NewStub<v1::AccessService>(),
                         &v1::AccessService::Stub::ListAuditEntries, {}, admin);
  REQUIRE(audit.status.ok());
  std::vector<std::string> stored;
  for (const v1::AuditEntry& entry : audit.response.entries()) {
    const bool is_upload = entry.method().find("UploadClip") != std::string::npos;
    if (is_upload && entry.code() == 0) stored.push_back(entry.resource());
  }
  CHECK(stored == std::vector<std::string>{"databases/db/clips/walk"});
}

}  // namespace motiondb::tests::upload_test
