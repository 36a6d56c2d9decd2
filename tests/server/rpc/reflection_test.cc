// A client that uses only reflection: it reads the descriptors of the services, builds a request,
// calls the server and reads the response. It includes no generated code of our protocol.
#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/descriptor_database.h>
#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "tests/server/rpc/listed_services.h"
#include "tests/support/raw_call.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::reflection_test {
namespace {

// Field numbers of grpc.reflection.v1alpha.
constexpr int kFileContainingSymbol = 4;    // of ServerReflectionRequest
constexpr int kFileDescriptorResponse = 4;  // of ServerReflectionResponse

// Returns the files that define a symbol, with their imports.
std::unique_ptr<google::protobuf::SimpleDescriptorDatabase> ReadDescriptors(
    TestServer& server, const std::string& symbol) {
  const RawAnswer answer =
      RawCall(server.channel(), kReflection, WithString(kFileContainingSymbol, symbol));
  REQUIRE(answer.status.ok());
  const auto responses = Values(answer.bytes, kFileDescriptorResponse);
  REQUIRE(responses.size() == 1);
  auto files = std::make_unique<google::protobuf::SimpleDescriptorDatabase>();
  for (const std::string& bytes : Values(responses[0], 1)) {
    google::protobuf::FileDescriptorProto file;
    REQUIRE(file.ParseFromString(bytes));
    REQUIRE(files->Add(file));
  }
  return files;
}

TEST_CASE("Reflection: lists the services", "[server][rpc]") {
  TestServer server;
  const auto names = ListServices(server);
  for (const char* service :
       {"motiondb.v1.DatabaseService", "motiondb.v1.ClipService", "motiondb.v1.ModelService",
        "motiondb.v1.OperationService", "motiondb.v1.QueryService", "motiondb.v1.ObserveService",
        "grpc.health.v1.Health"}) {
    INFO(service);
    CHECK(std::ranges::count(names, service) == 1);
  }
}

TEST_CASE("Reflection: is sufficient to make a call", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const auto files = ReadDescriptors(server, "motiondb.v1.DatabaseService");
  const google::protobuf::DescriptorPool pool(files.get());
  const auto* service = pool.FindServiceByName("motiondb.v1.DatabaseService");
  REQUIRE(service != nullptr);
  const auto* method = service->FindMethodByName("GetDatabase");
  REQUIRE(method != nullptr);

  google::protobuf::DynamicMessageFactory factory;
  const std::unique_ptr<google::protobuf::Message> request(
      factory.GetPrototype(method->input_type())->New());
  REQUIRE(google::protobuf::util::JsonStringToMessage(
              R"({"name": "databases/db", "view": "DATABASE_VIEW_FULL"})", request.get())
              .ok());
  const RawAnswer answer =
      RawCall(server.channel(), "/" + service->full_name() + "/" + method->name(),
              request->SerializeAsString());
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());

  const std::unique_ptr<google::protobuf::Message> response(
      factory.GetPrototype(method->output_type())->New());
  REQUIRE(response->ParseFromString(answer.bytes));
  const google::protobuf::Message* part = response.get();
  for (const char* const field : {"database", "statistics"}) {
    part = &part->GetReflection()->GetMessage(*part, part->GetDescriptor()->FindFieldByName(field));
  }
  const auto* frame_count = part->GetDescriptor()->FindFieldByName("frame_count");
  REQUIRE(frame_count != nullptr);
  CHECK(part->GetReflection()->GetInt32(*part, frame_count) == 360);
}

}  // namespace
}  // namespace motiondb::tests::reflection_test
