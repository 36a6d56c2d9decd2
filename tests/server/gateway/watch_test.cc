// Streams that last, and uploads, through the HTTP API.
#include <catch2/catch.hpp>
#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/escaping.h"
#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/observe.grpc.pb.h"
#include "tests/server/gateway/web_client.h"
#include "tests/server/gateway/web_server.h"
#include "tests/server/rpc/observing_client.h"
#include "tests/server/rpc/status_of.h"

namespace motiondb::tests::gateway_watch_test {
namespace {

using nlohmann::json;

constexpr char kUpload[] = "/motiondb.v1.ClipService/UploadClip";

void SendStreamRequest(WebClient& client, const std::string& path, const json& request,
                       Headers headers = {}) {
  headers.emplace_back("Content-Type", "application/connect+json");
  REQUIRE(client.Send(HttpText("POST", path, headers, EnvelopeText(0, request.dump()))));
}

// Returns the messages of a stream, and its end.
std::pair<std::vector<json>, json> ReadStream(WebClient& client) {
  const HttpReply reply = client.Read();
  REQUIRE(reply.status == 200);
  std::pair<std::vector<json>, json> read;
  for (const auto& [flags, content] : Envelopes(reply.body)) {
    INFO(content);
    if (flags == 2) {
      read.second = json::parse(content);
    } else {
      read.first.push_back(json::parse(content));
    }
  }
  return read;
}

void AwaitOpenStreams(WebServer& server, int count) {
  while (StatusOf(*server.operator->()).open_stream_count() < count) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

void DeleteDatabase(WebServer& server) {
  v1::DeleteDatabaseRequest request;
  request.set_name("databases/db");
  const auto stub = server->NewStub<v1::DatabaseService>();
  REQUIRE(Ask(*stub, &v1::DatabaseService::Stub::DeleteDatabase, request).status.ok());
}

}  // namespace

TEST_CASE("Gateway: WatchDatabase sends changes until the database is deleted",
          "[server][gateway]") {
  WebServer server;
  server->CreateTrained("db");
  WebClient client(server.address());
  SendStreamRequest(client, "/motiondb.v1.DatabaseService/WatchDatabase",
                    {{"name", "databases/db"}});
  AwaitOpenStreams(server, 1);
  v1::UpdateClipRequest update;
  update.mutable_clip()->set_name("databases/db/clips/walk");
  update.mutable_clip()->set_title("<b>first</b>");
  update.mutable_update_mask()->add_paths("title");
  const auto updated =
      Ask(*server->NewStub<v1::ClipService>(), &v1::ClipService::Stub::UpdateClip, update);
  REQUIRE(updated.status.ok());
  std::this_thread::sleep_for(std::chrono::milliseconds(200));  // until the change is sent
  DeleteDatabase(server);
  const auto [messages, end] = ReadStream(client);
  CHECK(end["error"]["code"] == "not_found");
  int walks = 0;
  for (const json& message : messages) {
    if (!message.contains("clip") || message["clip"]["name"] != "databases/db/clips/walk") continue;
    ++walks;
    if (message["clip"].value("title", "") != "<b>first</b>") continue;
    CHECK(message["revision"] == std::to_string(updated.response.revision()));
    walks += 10;
  }
  CHECK(walks > 10);
}

TEST_CASE("Gateway: calls that wait end at their deadline", "[server][gateway]") {
  WebServer server;
  server->CreateTrained("db");
  WebClient client(server.address());
  SendStreamRequest(client, "/motiondb.v1.DatabaseService/WatchDatabase",
                    {{"name", "databases/db"}}, {{"Connect-Timeout-Ms", "300"}});
  const auto begin = std::chrono::steady_clock::now();
  const auto [messages, end] = ReadStream(client);
  CHECK(end["error"]["code"] == "deadline_exceeded");
  CHECK(std::chrono::steady_clock::now() - begin >= std::chrono::milliseconds(250));
  AwaitOpenStreams(server, 0);

  // A wait for an operation ends before the deadline, with the operation as it is.
  server->gate().Close();
  const auto ingested = server->IngestFigure("db", "more", "walk", {.phase = 2});
  const HttpReply waited =
      Post(server.address(), "/motiondb.v1.OperationService/WaitOperation",
           {{"Content-Type", "application/json"}, {"Connect-Timeout-Ms", "500"}},
           json{{"name", ingested.operation().name()}}.dump());
  INFO(waited.body);
  REQUIRE(waited.status == 200);
  CHECK(json::parse(waited.body)["operation"]["state"] == "OPERATION_STATE_RUNNING");
  server->gate().Open();
  server->Wait(ingested.operation().name());
}

TEST_CASE("Gateway: a spectator of a stream gets its answers", "[server][gateway]") {
  WebServer server;
  server->CreateTrained("db");
  const v1::MarkerObservation motion = observing::WalkingMarkers(*server.operator->());
  observing::Stream stream(*server.operator->());
  REQUIRE(stream.Send(observing::Start(motion)));
  stream.Ask(observing::Frames(motion, 0, 1, 0));
  const HttpReply listed =
      Post(server.address(), "/motiondb.v1.ObserveService/ListStreams",
           {{"Content-Type", "application/json"}}, R"({"parent":"databases/db"})");
  REQUIRE(listed.status == 200);
  const json streams = json::parse(listed.body)["streams"];
  REQUIRE(streams.size() == 1);
  WebClient client(server.address());
  SendStreamRequest(client, "/motiondb.v1.ObserveService/WatchStream",
                    {{"name", streams[0]["name"]}});
  AwaitOpenStreams(server, 2);
  constexpr int kLast = 30;
  for (int frame = 1; frame <= kLast; ++frame) {
    stream.Ask(observing::Frames(motion, frame, 1, frame));
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  stream.Close();
  const auto [messages, end] = ReadStream(client);
  CHECK(end == json::object());
  REQUIRE(messages.size() >= 2);
  CHECK(messages[0]["stream"]["name"] == streams[0]["name"]);
  CHECK(messages.back()["answer"]["frame"] == std::to_string(kLast));
  std::string positions;
  REQUIRE(absl::Base64Unescape(messages.back()["markerPositions"].get<std::string>(), &positions));
  CHECK(positions == observing::Frames(motion, kLast, 1, 0).frames().positions());
  v1::ObserveResponse none;
  CHECK_FALSE(stream.Receive(none));
  CHECK(stream.Finish().ok());
}

TEST_CASE("Gateway: UploadClip stores a file, as JSON and as protobuf", "[server][gateway]") {
  WebServer server;
  server->CreateDatabase("db");
  v1::UploadClipRequest request;
  request.mutable_header()->set_parent("databases/db");
  request.mutable_header()->set_file_name("walk.bvh");
  request.mutable_header()->set_title("A walk");
  request.mutable_header()->add_tags("outdoor");
  request.set_file(WriteBvh({}));
  json as_json = {
      {"header", {{"parent", "databases/db"}, {"fileName", "walk.bvh"}, {"validateOnly", true}}},
      {"file", absl::Base64Escape(request.file())}};
  const auto upload = [&](const std::string& type, const std::string& body) {
    return Post(server.address(), kUpload, {{"Content-Type", type}}, body);
  };
  const HttpReply checked = upload("application/json", as_json.dump());
  INFO(checked.body);
  REQUIRE(checked.status == 200);
  CHECK(json::parse(checked.body)["points"].size() > 10);

  const HttpReply stored = upload("application/proto", request.SerializeAsString());
  REQUIRE(stored.status == 200);
  v1::UploadClipResponse response;
  REQUIRE(response.ParseFromString(stored.body));
  CHECK(response.clip().name() == "databases/db/clips/walk");
  CHECK(response.clip().title() == "A walk");
  CHECK(server->Wait(response.operation().name()).state() == v1::OPERATION_STATE_SUCCEEDED);

  CHECK(json::parse(upload("application/json", as_json.dump()).body)["code"] == "already_exists");
  as_json["file"] = absl::Base64Escape("garbage");
  CHECK(json::parse(upload("application/json", as_json.dump()).body)["code"] == "invalid_argument");
  as_json["file"] = "not base64 \x01";
  CHECK(upload("application/json", as_json.dump()).status == 400);
  as_json["file"] = "";
  as_json["header"]["tags"] = {"Not good"};
  CHECK(json::parse(upload("application/json", as_json.dump()).body)["message"]
            .get<std::string>()
            .starts_with("header.tags[0]"));
}

}  // namespace motiondb::tests::gateway_watch_test
