// Every RPC at a real server, by callers with and without permission.
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <catch2/catch.hpp>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "motiondb/v1/access.grpc.pb.h"
#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/error.pb.h"
#include "motiondb/v1/observe.grpc.pb.h"
#include "motiondb/v1/operation.pb.h"
#include "motiondb/v1/store.pb.h"
#include "server/security/authorize.h"
#include "tests/support/raw_call.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::every_call_test {
namespace {

using google::protobuf::DescriptorPool;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::MessageFactory;
using grpc::StatusCode;

// Sets the text field at `path` and creates the messages on the path.
void SetText(Message& message, const std::string& path, const std::string& text) {
  const std::size_t dot = path.find('.');
  const FieldDescriptor* field = message.GetDescriptor()->FindFieldByName(path.substr(0, dot));
  REQUIRE(field != nullptr);
  if (dot == std::string::npos) {
    message.GetReflection()->SetString(&message, field, text);
  } else {
    SetText(*message.GetReflection()->MutableMessage(&message, field), path.substr(dot + 1), text);
  }
}

class EveryCall {
 public:
  EveryCall() {
    server_.CreateDatabase("here");
    server_.CreateDatabase("elsewhere");
    operation_ = server_.IngestFigure("here", "walk", "walk", {}).operation().name();
    server_.Wait(operation_);
    for (const auto role : {v1::ROLE_READER, v1::ROLE_INGESTER, v1::ROLE_ADMIN}) {
      tokens[role] = Make(role, "").secret();
      here[role] = Make(role, "databases/here").secret();
      elsewhere[role] = Make(role, "databases/elsewhere").secret();
    }
    const auto ended = Make(v1::ROLE_ADMIN, "");
    revoked = ended.secret();
    v1::RevokeTokenRequest revoke;
    revoke.set_name(ended.token().name());
    const auto stub = server_.NewStub<v1::AccessService>();
    REQUIRE(Ask(*stub, &v1::AccessService::Stub::RevokeToken, revoke).status.ok());
    expired = Make(v1::ROLE_ADMIN, "", 1000).secret();
    server_.options().security.authentication = server::Authentication::kToken;
    server_.options().security.failures_per_minute = 100'000;
    server_.Restart();
  }

  // Makes a call of `rule` on the database "here", or on a resource in it, and returns its status.
  grpc::Status Call(const server::CallRule& rule, const Headers& headers) {
    const std::string full = "motiondb.v1." + std::string(rule.method);
    const auto* method = DescriptorPool::generated_pool()->FindMethodByName(full);
    INFO(full);
    REQUIRE(method != nullptr);
    const std::unique_ptr<Message> request(
        MessageFactory::generated_factory()->GetPrototype(method->input_type())->New());
    if (!rule.field.empty()) SetText(*request, std::string(rule.field), Subject(rule));
    return RawCall(server_.channel(), "/" + method->service()->full_name() + "/" + method->name(),
                   request->SerializeAsString(), headers)
        .status;
  }
  grpc::Status CallAs(const server::CallRule& rule, const std::string& token) {
    return Call(rule, {{"authorization", "Bearer " + token}});
  }

  TestServer& server() { return server_; }

  std::map<v1::Role, std::string> tokens;     // for all databases
  std::map<v1::Role, std::string> here;       // for "here"
  std::map<v1::Role, std::string> elsewhere;  // for "elsewhere"
  std::string revoked;
  std::string expired;

 private:
  v1::CreateTokenResponse Make(v1::Role role, const std::string& database, int life_ns = 0) {
    v1::CreateTokenRequest request;
    request.mutable_token()->set_role(role);
    request.mutable_token()->set_database(database);
    if (life_ns > 0) request.mutable_ttl()->set_nanos(life_ns);
    const auto stub = server_.NewStub<v1::AccessService>();
    const auto answer = Ask(*stub, &v1::AccessService::Stub::CreateToken, request);
    INFO(answer.status.error_message());
    REQUIRE(answer.status.ok());
    return answer.response;
  }

  // Returns a resource in "here" that no call can change.
  std::string Subject(const server::CallRule& rule) const {
    const std::string method(rule.method);
    if (rule.scope == server::Scope::kOperation) return operation_;
    if (rule.scope != server::Scope::kDatabase) return "";
    if (method == "DatabaseService.DeleteDatabase") return "databases/here/none";
    if (method == "DatabaseService.WatchDatabase") return "databases/here/none";  // would not end
    return "databases/here";
  }

  TestServer server_;
  std::string operation_;
};

bool IsRefused(const grpc::Status& status) {
  return status.error_code() == StatusCode::UNAUTHENTICATED ||
         status.error_code() == StatusCode::PERMISSION_DENIED;
}

v1::Role ToProto(storage::Role role) { return static_cast<v1::Role>(role); }

TEST_CASE("Every call: succeeds with permission only", "[security][rpc]") {
  v1::BackupStoreRequest::descriptor();  // links its file
  EveryCall calls;
  int count = 0;
  for (const server::CallRule& rule : server::CallRules()) {
    INFO(rule.method);
    const auto code = [&](const std::string& token) {
      return calls.CallAs(rule, token).error_code();
    };
    ++count;
    CHECK(calls.Call(rule, {}).error_code() == StatusCode::UNAUTHENTICATED);
    CHECK(calls.Call(rule, {{"authorization", "Basic bWU6bWU="}}).error_code() ==
          StatusCode::UNAUTHENTICATED);
    CHECK(code("mdb_0123456789ab_" + std::string(64, '0')) == StatusCode::UNAUTHENTICATED);
    CHECK(code(calls.revoked) == StatusCode::UNAUTHENTICATED);
    CHECK(code(calls.expired) == StatusCode::UNAUTHENTICATED);
    for (const auto& [role, token] : calls.tokens) {
      INFO("role " << role);
      const bool may = role >= ToProto(rule.min_role);
      const grpc::Status status = calls.CallAs(rule, token);
      INFO(status.error_message());
      CHECK(IsRefused(status) == !may);
      if (!may) CHECK(status.error_code() == StatusCode::PERMISSION_DENIED);

      const bool may_here = may && rule.scope != server::Scope::kServer;
      CHECK(IsRefused(calls.CallAs(rule, calls.here[role])) == !may_here);
      const bool may_elsewhere = may && rule.scope == server::Scope::kList;
      CHECK(IsRefused(calls.CallAs(rule, calls.elsewhere[role])) == !may_elsewhere);
      if (!may_elsewhere) CHECK(code(calls.elsewhere[role]) == StatusCode::PERMISSION_DENIED);
    }
  }
  CHECK(count >= 36);
}

// Returns the request id in the details of an error.
std::string RequestIdIn(const grpc::Status& status) {
  v1::Status details;
  if (!details.ParseFromString(status.error_details())) return "(details do not parse)";
  for (const auto& detail : details.details()) {
    v1::RequestInfo info;
    if (detail.type_url().ends_with("/google.rpc.RequestInfo") &&
        info.ParseFromString(detail.value())) {
      return info.request_id();
    }
  }
  return "(none)";
}

TEST_CASE("Every call: errors have the caller's request id, or one of the server",
          "[security][rpc]") {
  EveryCall calls;
  for (const server::CallRule& rule : server::CallRules()) {
    const grpc::Status status = calls.Call(rule, {{"x-request-id", "robot-7/42"}});
    INFO(rule.method);
    CHECK(RequestIdIn(status) == "robot-7/42");
    CHECK(RequestIdIn(calls.Call(rule, {})).size() == 16);
    CHECK(RequestIdIn(calls.Call(rule, {{"x-request-id", std::string(129, 'x')}})).size() == 16);
  }
}

TEST_CASE("Every call: is in the audit log exactly if its row requires it", "[security][rpc]") {
  EveryCall calls;
  const std::string token = calls.tokens[v1::ROLE_ADMIN];
  std::set<std::string> expected;
  for (const server::CallRule& rule : server::CallRules()) {
    const std::string method(rule.method);
    calls.Call(rule, {{"authorization", "Bearer " + token}, {"x-request-id", method}});
    if (rule.recorded) expected.insert(method);
  }
  const auto stub = calls.server().NewStub<v1::AccessService>();
  v1::ListAuditEntriesRequest request;
  request.set_page_size(1000);
  const auto audit = Ask(*stub, &v1::AccessService::Stub::ListAuditEntries, request, token);
  REQUIRE(audit.status.ok());
  std::set<std::string> recorded;
  for (const v1::AuditEntry& entry : audit.response.entries()) {
    if (entry.request_id() == entry.method()) recorded.insert(entry.method());
  }
  CHECK(recorded == expected);
}

TEST_CASE("Every call: a stream without a message is checked, too", "[security][rpc]") {
  EveryCall calls;
  const auto stub = calls.server().NewStub<v1::ObserveService>();
  grpc::ClientContext observe;
  const auto observation = stub->Observe(&observe);
  observation->WritesDone();
  CHECK(observation->Finish().error_code() == StatusCode::UNAUTHENTICATED);
  grpc::ClientContext ingest;
  v1::IngestClipResponse response;
  const auto writer = calls.server().NewStub<v1::ClipService>()->IngestClip(&ingest, &response);
  writer->WritesDone();
  CHECK(writer->Finish().error_code() == StatusCode::UNAUTHENTICATED);
}

TEST_CASE("Every call: health needs no token; reflection is off with authentication",
          "[security][rpc]") {
  TestServer server;
  constexpr char kReflection[] = "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo";
  const std::string list_services("\x3a\x01*", 3);
  CHECK(RawCall(server.channel(), kReflection, list_services).status.ok());
  server.options().security.authentication = server::Authentication::kToken;
  server.Restart();
  CHECK(RawCall(server.channel(), "/grpc.health.v1.Health/Check", "").status.ok());
  CHECK(RawCall(server.channel(), kReflection, list_services).status.error_code() ==
        StatusCode::UNIMPLEMENTED);
}

}  // namespace
}  // namespace motiondb::tests::every_call_test
