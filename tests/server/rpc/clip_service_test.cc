#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <string>
#include <vector>

#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/database.pb.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::clip_service_test {
namespace {

using Stub = v1::ClipService::Stub;

v1::IngestClipHeader Header(const std::string& file_name) {
  v1::IngestClipHeader header;
  header.set_parent("databases/db");
  header.set_file_name(file_name);
  return header;
}

struct Exported {
  grpc::Status status;
  v1::ExportClipHeader header;
  std::string file;
};

Exported Export(Stub& stub, const std::string& name) {
  grpc::ClientContext context;
  v1::ExportClipRequest request;
  request.set_name(name);
  const auto reader = stub.ExportClip(&context, request);
  Exported exported;
  v1::ExportClipResponse message;
  while (reader->Read(&message)) {
    if (message.has_header()) exported.header = message.header();
    CHECK(message.file_block().size() <= 1 << 20);
    exported.file += message.file_block();
  }
  exported.status = reader->Finish();
  return exported;
}

TEST_CASE("ClipService: an ingested clip can be read, listed and exported", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  const auto stub = server.NewStub<v1::ClipService>();
  const StickFigure figure{.frame_count = 90};
  const auto ingested = server.IngestFigure("db", "walk", "walking", figure);
  CHECK(ingested.clip().name() == "databases/db/clips/walk");
  CHECK(ingested.clip().label() == "walking");
  CHECK(ingested.clip().file_name() == "walk.bvh");
  CHECK(ingested.clip().format() == v1::FILE_FORMAT_BVH);
  CHECK(ingested.clip().frame_count() == 90);
  CHECK(ingested.clip().duration_seconds() == Approx(1.5));
  CHECK(ingested.operation().state() == v1::OPERATION_STATE_PENDING);
  CHECK(ingested.operation().database() == "databases/db");

  v1::GetClipRequest get;
  get.set_name(ingested.clip().name());
  const auto got = Ask(*stub, &Stub::GetClip, get);
  REQUIRE(got.status.ok());
  CHECK(got.response.clip().SerializeAsString() == ingested.clip().SerializeAsString());

  v1::ListClipsRequest list;
  list.set_parent("databases/db");
  const auto listed = Ask(*stub, &Stub::ListClips, list);
  REQUIRE(listed.status.ok());
  REQUIRE(listed.response.clips_size() == 1);
  CHECK(listed.response.clips(0).name() == ingested.clip().name());

  const Exported exported = Export(*stub, ingested.clip().name());
  REQUIRE(exported.status.ok());
  CHECK(exported.header.clip().file_name() == "walk.bvh");
  CHECK(exported.file == WriteBvh(figure));
}

TEST_CASE("ClipService: a large file is ingested and exported in blocks", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  const auto stub = server.NewStub<v1::ClipService>();
  const std::string bytes = WriteBvh({.frame_count = 12'000});
  REQUIRE(bytes.size() > 1 << 20);
  v1::IngestClipResponse ingested;
  REQUIRE(server.Ingest(Header("long.bvh"), bytes, &ingested).ok());
  const Exported exported = Export(*stub, ingested.clip().name());
  REQUIRE(exported.status.ok());
  CHECK(exported.file == bytes);
}

TEST_CASE("ClipService: a bad ingest is refused with a reason and changes nothing",
          "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  const std::string walk = WriteBvh({});
  const auto bad_file = server.Ingest(Header("bad.bvh"), walk.substr(0, walk.size() - 300));
  CHECK(bad_file.error_code() == grpc::StatusCode::INVALID_ARGUMENT);
  CHECK(bad_file.error_message().find("bad.bvh:") != std::string::npos);
  CHECK(ViolatedFields(bad_file) == "file_block");
  CHECK(server.Ingest(Header("empty.bvh"), "").error_code() == grpc::StatusCode::INVALID_ARGUMENT);
  CHECK(ViolatedFields(server.Ingest(Header("walk.txt"), walk)) == "header.file_name");
  v1::IngestClipHeader nowhere = Header("walk.bvh");
  nowhere.set_parent("databases/other");
  CHECK(server.Ingest(nowhere, walk).error_code() == grpc::StatusCode::NOT_FOUND);
  REQUIRE(server.Ingest(Header("walk.bvh"), walk).ok());
  CHECK(server.Ingest(Header("again.bvh"), walk).error_code() == grpc::StatusCode::ALREADY_EXISTS);
  CHECK(server.Describe("db").stored_clip_count() == 1);
}

TEST_CASE("ClipService: a file above the size limit is refused", "[server][rpc]") {
  server::ServerOptions options;
  options.engine.max_file_bytes = 20'000;
  TestServer server(options);
  server.CreateDatabase("db");
  const auto refused = server.Ingest(Header("long.bvh"), WriteBvh({.frame_count = 1000}));
  CHECK(refused.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST_CASE("ClipService: a cancelled ingest stores nothing", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  const auto stub = server.NewStub<v1::ClipService>();
  for (int i = 0; i < 10; ++i) {
    grpc::ClientContext context;
    v1::IngestClipResponse response;
    const auto writer = stub->IngestClip(&context, &response);
    v1::IngestClipRequest message;
    *message.mutable_header() = Header("walk.bvh");
    REQUIRE(writer->Write(message));
    message.set_file_block(WriteBvh({.phase = 0.1 * i}));
    REQUIRE(writer->Write(message));
    context.TryCancel();
    CHECK(writer->Finish().error_code() == grpc::StatusCode::CANCELLED);
  }
  server.Restart();  // waits for calls in flight
  CHECK(server.Describe("db").stored_clip_count() == 0);
}

TEST_CASE("ClipService: a deleted clip is removed from the model", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const auto stub = server.NewStub<v1::ClipService>();
  v1::DeleteClipRequest request;
  request.set_name("databases/db/clips/squat");
  const auto deleted = Ask(*stub, &Stub::DeleteClip, request);
  REQUIRE(deleted.status.ok());
  CHECK(server.Wait(deleted.response.operation().name()).rebuild().model() ==
        "databases/db/models/2");
  CHECK(server.Describe("db").clip_count() == 2);
  CHECK(Ask(*stub, &Stub::DeleteClip, request).status.error_code() == grpc::StatusCode::NOT_FOUND);
  CHECK(Export(*stub, request.name()).status.error_code() == grpc::StatusCode::NOT_FOUND);
}

TEST_CASE("ClipService: lists clips page by page", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const auto stub = server.NewStub<v1::ClipService>();
  v1::ListClipsRequest request;
  request.set_parent("databases/db");
  request.set_page_size(2);
  const auto first = Ask(*stub, &Stub::ListClips, request);
  REQUIRE(first.status.ok());
  REQUIRE(first.response.clips_size() == 2);
  CHECK(first.response.clips(0).name() == "databases/db/clips/squat");
  request.set_page_token(first.response.next_page_token());
  const auto second = Ask(*stub, &Stub::ListClips, request);
  REQUIRE(second.response.clips_size() == 1);
  CHECK(second.response.clips(0).name() == "databases/db/clips/wave");
  CHECK(second.response.next_page_token().empty());
  request.set_parent("databases/none");
  request.clear_page_token();
  CHECK(Ask(*stub, &Stub::ListClips, request).status.error_code() == grpc::StatusCode::NOT_FOUND);
  request.set_parent("none");
  CHECK(ViolatedFields(Ask(*stub, &Stub::ListClips, request).status) == "parent");
}

TEST_CASE("ClipService: skeletons are stored once and can be read", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const auto stub = server.NewStub<v1::ClipService>();
  v1::ListSkeletonsRequest list;
  list.set_parent("databases/db");
  const auto listed = Ask(*stub, &Stub::ListSkeletons, list);
  REQUIRE(listed.status.ok());
  REQUIRE(listed.response.skeletons_size() == 1);
  v1::GetSkeletonRequest get;
  get.set_name(listed.response.skeletons(0).name());
  const auto got = Ask(*stub, &Stub::GetSkeleton, get);
  REQUIRE(got.status.ok());
  const v1::Skeleton& skeleton = got.response.skeleton();
  CHECK(skeleton.joints(0).name() == "Hips");
  CHECK(!skeleton.joints(0).has_parent_joint());
  CHECK(skeleton.joints(0).dofs_size() == 6);
  CHECK(skeleton.joints(0).dofs(0).translation());
  CHECK(skeleton.dof_count() == 33);
  get.set_name("databases/db/skeletons/none");
  CHECK(Ask(*stub, &Stub::GetSkeleton, get).status.error_code() == grpc::StatusCode::NOT_FOUND);
}

TEST_CASE("ClipService: skeletons in pages of any size, each once", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  constexpr int kSkeletons = 19;
  for (int i = 0; i < kSkeletons; ++i) {
    std::string bvh = WriteBvh({.phase = 0.1 * i});
    bvh.replace(bvh.find("OFFSET 9 -4 0"), 8, fmt::format("OFFSET {}", 9 + 0.1 * i));
    REQUIRE(server.Ingest(Header(fmt::format("walk{}.bvh", i)), bvh).ok());
  }
  const auto stub = server.NewStub<v1::ClipService>();
  for (const int size : {1, 7, 8, 9, 19, 100}) {
    CAPTURE(size);
    v1::ListSkeletonsRequest list;
    list.set_parent("databases/db");
    list.set_page_size(size);
    std::vector<std::string> names;
    do {
      const auto page = Ask(*stub, &Stub::ListSkeletons, list);
      REQUIRE(page.status.ok());
      CHECK(page.response.skeletons_size() <= size);
      for (const auto& skeleton : page.response.skeletons()) names.push_back(skeleton.name());
      list.set_page_token(page.response.next_page_token());
      CHECK((names.size() < kSkeletons) == !list.page_token().empty());
    } while (!list.page_token().empty());
    CHECK(names.size() == kSkeletons);
    CHECK(std::ranges::adjacent_find(names, std::greater_equal<>()) == names.end());
  }
}

}  // namespace
}  // namespace motiondb::tests::clip_service_test
