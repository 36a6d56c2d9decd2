// Every RPC through the HTTP API gives the answer of gRPC: unary RPCs as JSON and as protobuf,
// streams message by message.
#include <google/protobuf/descriptor.h>
#include <google/protobuf/util/json_util.h>
#include <grpcpp/client_context.h>
#include <grpcpp/completion_queue.h>
#include <grpcpp/generic/generic_stub.h>

#include <catch2/catch.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/query.pb.h"
#include "server/gateway/connect_json.h"
#include "server/gateway/http_content.h"
#include "server/rpc/call_identity.h"
#include "tests/server/gateway/web_client.h"
#include "tests/server/gateway/web_server.h"
#include "tests/support/raw_call.h"

namespace motiondb::tests::rpc_test {
namespace {

using google::protobuf::DescriptorPool;
using google::protobuf::MethodDescriptor;
using nlohmann::json;

std::vector<const MethodDescriptor*> Methods() {
  std::vector<const MethodDescriptor*> methods;
  for (const std::string& name : server::MethodNames()) {
    methods.push_back(DescriptorPool::generated_pool()->FindMethodByName("motiondb.v1." + name));
    REQUIRE(methods.back() != nullptr);
  }
  return methods;
}

std::string PathOf(const MethodDescriptor& method) {
  return "/" + method.service()->full_name() + "/" + method.name();
}

json Observation() {
  std::string text;
  const auto status = google::protobuf::util::MessageToJsonString(WalkObservation(), &text);
  REQUIRE(status.ok());
  return json::parse(text);
}

// Requests of the example database by method; others are empty.
std::map<std::string, json> Requests() {
  const json observed = {{"database", "databases/demo"}, {"observation", Observation()}};
  json predict = observed;
  predict["atSeconds"] = 0.3;
  json plan = {{"database", "databases/demo"},
               {"goal", {{"xM", 0.4}}},
               {"clipStart", {{"clip", "databases/demo/clips/walk"}}}};
  return {{"GetDatabase", {{"name", "databases/demo"}, {"view", "DATABASE_VIEW_FULL"}}},
          {"ListClips", {{"parent", "databases/demo"}, {"pageSize", 2}}},
          {"GetClip", {{"name", "databases/demo/clips/walk"}}},
          {"ListSkeletons", {{"parent", "databases/demo"}}},
          {"GetSkeleton", {{"name", "databases/demo/skeletons/Hips"}}},
          {"GetMarkerSet", {{"database", "databases/demo"}}},
          {"GetModel", {{"name", "databases/demo/models/1"}}},
          {"ListModels", {{"parent", "databases/demo"}}},
          {"ListNodes", {{"parent", "databases/demo/models/1"}, {"layer", 2}}},
          {"ListTransitions", {{"parent", "databases/demo/models/1"}, {"layer", 2}}},
          {"ListOperations", {{"parent", "databases/demo"}}},
          {"ListStreams", {{"parent", "databases/demo"}}},
          {"Recognize", observed},
          {"Estimate", observed},
          {"Predict", predict},
          {"Find", observed},
          {"Represent", observed},
          {"PredictSeries", {{"prediction", observed}, {"everySeconds", 0.2}}},
          {"Plan", plan},
          {"ExportClip", {{"name", "databases/demo/clips/walk"}}},
          {"ExportDatabase", {{"name", "databases/demo"}}},
          {"GetFigure", {{"name", "databases/demo/clips/walk"}}},
          {"GetNodePoses",
           {{"parent", "databases/demo/models/current"}, {"layer", 2}, {"nodeIds", {1, 0}}}},
          {"ReadClipMotion", {{"name", "databases/demo/clips/walk"}, {"joints", true}}},
          {"ReadStateMap", {{"parent", "databases/demo/models/current"}, {"maxPoints", 30}}},
          {"ReadStates", {{"name", "databases/demo/models/1"}}}};
}

// Removes what differs between two equal calls: times and the id of the request.
void Normalize(json& value) {
  static const std::set<std::string> kVolatile = {
      "requestId", "time", "seconds", "uptime", "memory", "searchSeconds", "value", "totalSeconds"};
  if (value.is_object()) {
    for (const std::string& name : kVolatile) value.erase(name);
  }
  if (value.is_structured()) {
    for (auto& item : value) Normalize(item);
  }
}

json Normalized(const std::string& text) {
  json value = json::parse(text);
  Normalize(value);
  return value;
}

// Status and statistics of the server, and the audit log, change with every call.
bool Changes(const MethodDescriptor& method) {
  static const std::set<std::string> kNames = {"GetServerStatus", "ListAuditEntries"};
  return kNames.contains(method.name());
}

TEST_CASE("Gateway: every unary RPC has the answer of gRPC", "[server][gateway]") {
  WebServer server;
  server->CreateTrained("demo");
  const auto requests = Requests();
  int succeeded = 0;
  WebClient client(server.address());
  for (const MethodDescriptor* const method : Methods()) {
    if (method->client_streaming() || method->server_streaming()) continue;
    INFO(method->full_name());
    const auto found = requests.find(method->name());
    const std::string request = found == requests.end() ? "{}" : found->second.dump();
    const auto bytes = server::ProtoFromJson(*method->input_type(), request);
    INFO(bytes.status().ToString());
    REQUIRE(bytes.ok());
    const RawAnswer expected = RawCall(server->channel(), PathOf(*method), *bytes);

    client.Send(HttpText("POST", PathOf(*method), {{"Content-Type", "application/json"}}, request));
    const HttpReply as_json = client.Read();
    client.Send(HttpText("POST", PathOf(*method), {{"Content-Type", "application/proto"}}, *bytes));
    const HttpReply as_proto = client.Read();
    INFO(as_json.body);
    if (!expected.status.ok()) {
      const std::string error = server::ConnectErrorJson(expected.status);
      for (const HttpReply& reply : {as_json, as_proto}) {
        CHECK(reply.status == static_cast<int>(server::HttpStatusOf(expected.status.error_code())));
        CHECK(Normalized(reply.body) == Normalized(error));
      }
      continue;
    }
    ++succeeded;
    REQUIRE(as_json.status == 200);
    REQUIRE(as_proto.status == 200);
    if (Changes(*method)) continue;
    const auto text = server::JsonFromProto(*method->output_type(), expected.bytes);
    REQUIRE(text.ok());
    CHECK(Normalized(as_json.body) == Normalized(*text));
    const auto proto_text = server::JsonFromProto(*method->output_type(), as_proto.body);
    REQUIRE(proto_text.ok());
    CHECK(Normalized(*proto_text) == Normalized(*text));
  }
  CHECK(succeeded >= 20);
}

// Returns all messages of a stream over gRPC.
std::vector<std::string> StreamOverGrpc(const std::shared_ptr<grpc::Channel>& channel,
                                        const std::string& path, const std::string& request) {
  grpc::GenericStub stub(channel);
  grpc::ClientContext context;
  grpc::CompletionQueue queue;
  const auto next = [&] {
    void* tag = nullptr;
    bool ok = false;
    return queue.Next(&tag, &ok) && ok;
  };
  const auto call = stub.PrepareCall(&context, path, &queue);
  call->StartCall(nullptr);
  REQUIRE(next());
  const grpc::Slice slice(request);
  call->WriteLast(grpc::ByteBuffer(&slice, 1), grpc::WriteOptions(), nullptr);
  REQUIRE(next());
  std::vector<std::string> messages;
  while (true) {
    grpc::ByteBuffer response;
    call->Read(&response, nullptr);
    if (!next()) break;
    std::vector<grpc::Slice> slices;
    REQUIRE(response.Dump(&slices).ok());
    std::string bytes;
    for (const auto& part : slices) {
      bytes.append(reinterpret_cast<const char*>(part.begin()), part.size());
    }
    messages.push_back(std::move(bytes));
  }
  grpc::Status status;
  call->Finish(&status, nullptr);
  next();
  INFO(status.error_message());
  CHECK(status.ok());
  queue.Shutdown();
  return messages;
}

TEST_CASE("Gateway: streams have the messages of gRPC", "[server][gateway]") {
  WebServer server;
  server->CreateTrained("demo");
  const auto requests = Requests();
  // These end with their client or their database (watch_test.cc).
  const std::set<std::string> endless = {"WatchDatabase", "WatchStream"};
  // Files of the store: each copy has other times.
  const std::set<std::string> files = {"BackupStore", "ExportDatabase"};
  for (const MethodDescriptor* const method : Methods()) {
    if (!method->server_streaming() || method->client_streaming()) continue;
    if (endless.contains(method->name())) continue;
    INFO(method->full_name());
    const auto found = requests.find(method->name());
    const std::string request = found == requests.end() ? "{}" : found->second.dump();
    const auto bytes = server::ProtoFromJson(*method->input_type(), request);
    REQUIRE(bytes.ok());
    const auto expected = StreamOverGrpc(server->channel(), PathOf(*method), *bytes);
    REQUIRE(!expected.empty());

    for (const bool is_json : {true, false}) {
      for (const bool zips : {false, true}) {
        Headers headers = {
            {"Content-Type", is_json ? "application/connect+json" : "application/connect+proto"}};
        if (zips) headers.emplace_back("Connect-Accept-Encoding", "gzip");
        const HttpReply reply = Post(server.address(), PathOf(*method), headers,
                                     EnvelopeText(0, is_json ? request : *bytes));
        REQUIRE(reply.status == 200);
        CHECK(reply.Field("connect-content-encoding") == (zips ? "gzip" : ""));
        auto envelopes = Envelopes(reply.body);
        REQUIRE(!envelopes.empty());
        CHECK(envelopes.back() == std::pair<int, std::string>(2, "{}"));
        envelopes.pop_back();
        if (files.contains(method->name())) continue;
        REQUIRE(envelopes.size() == expected.size());
        for (std::size_t i = 0; i < expected.size(); ++i) {
          auto [flags, message] = envelopes[i];
          if (flags == 1) {
            const auto unzipped =
                server::Gunzip(message, [](std::int64_t) { return absl::OkStatus(); });
            REQUIRE(unzipped.ok());
            message = *unzipped;
          }
          const auto text = server::JsonFromProto(*method->output_type(), expected[i]);
          const auto got = is_json ? absl::StatusOr<std::string>(message)
                                   : server::JsonFromProto(*method->output_type(), message);
          REQUIRE(text.ok());
          REQUIRE(got.ok());
          CHECK(Normalized(*got) == Normalized(*text));
        }
      }
    }
  }
}

TEST_CASE("Gateway: the OpenAPI document has every RPC of this port", "[server][gateway]") {
  WebServer server;
  WebClient client(server.address());
  client.Send(HttpText("GET", "/openapi.json", {}));
  const json document = json::parse(client.Read().body);
  std::set<std::string> documented;
  std::set<std::string> served;
  for (const auto& [path, operations] : document.at("paths").items()) {
    if (path.starts_with("/motiondb.v1.")) documented.insert(path);
  }
  const auto& schemas = document.at("components").at("schemas");
  for (const MethodDescriptor* const method : Methods()) {
    if (method->client_streaming()) continue;
    served.insert(PathOf(*method));
    for (const auto* const type : {method->input_type(), method->output_type()}) {
      INFO(type->full_name());
      REQUIRE(schemas.contains(type->full_name()));
      for (int i = 0; i < type->field_count(); ++i) {
        INFO(type->field(i)->json_name());
        CHECK(schemas[type->full_name()]["properties"].contains(type->field(i)->json_name()));
      }
    }
  }
  CHECK(documented == served);
}

}  // namespace
}  // namespace motiondb::tests::rpc_test
