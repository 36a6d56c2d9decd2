// The audit log: who, what, on which resource, from where, with which result.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <vector>

#include "motiondb/v1/access.grpc.pb.h"
#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/operation.grpc.pb.h"
#include "motiondb/v1/store.grpc.pb.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::audit_test {
namespace {

using Access = v1::AccessService::Stub;
using grpc::StatusCode;

std::vector<v1::AuditEntry> Audit(TestServer& server, const std::string& token = "",
                                  int page_size = 0) {
  const auto stub = server.NewStub<v1::AccessService>();
  std::vector<v1::AuditEntry> entries;
  v1::ListAuditEntriesRequest request;
  request.set_page_size(page_size);
  do {
    const auto page = Ask(*stub, &Access::ListAuditEntries, request, token);
    INFO(page.status.error_message());
    REQUIRE(page.status.ok());
    entries.insert(entries.end(), page.response.entries().begin(), page.response.entries().end());
    request.set_page_token(page.response.next_page_token());
  } while (!request.page_token().empty());
  return entries;
}

// "who method on -> code", oldest first.
std::vector<std::string> Lines(const std::vector<v1::AuditEntry>& entries) {
  std::vector<std::string> lines;
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry) {
    lines.push_back(entry->principal() + " " + entry->method() + " " + entry->resource() + " -> " +
                    std::to_string(entry->code()));
  }
  return lines;
}

v1::CreateTokenResponse NewToken(TestServer& server, v1::Role role) {
  v1::CreateTokenRequest wanted;
  wanted.mutable_token()->set_role(role);
  return Ask(*server.NewStub<v1::AccessService>(), &Access::CreateToken, wanted).response;
}

// Restarts with authentication by token.
void RequireTokens(TestServer& server) {
  server.options().security.authentication = server::Authentication::kToken;
  server.Restart();
}

template <typename Request>
Request Named(const std::string& name) {
  Request request;
  request.set_name(name);
  return request;
}

TEST_CASE("Audit: every change is recorded, newest first; reads are not", "[security][rpc]") {
  TestServer server;
  server.CreateDatabase("walks");
  const auto ingested = server.IngestFigure("walks", "walk", "walk", {});
  const std::string operation = server.Wait(ingested.operation().name()).name();
  server.Describe("walks");
  const auto clips = server.NewStub<v1::ClipService>();
  const auto deleted = Ask(*clips, &v1::ClipService::Stub::DeleteClip,
                           Named<v1::DeleteClipRequest>("databases/walks/clips/walk"));
  REQUIRE(deleted.status.ok());
  server.Wait(deleted.response.operation().name());
  const auto operations = server.NewStub<v1::OperationService>();
  Ask(*operations, &v1::OperationService::Stub::CancelOperation,
      Named<v1::CancelOperationRequest>(operation));
  const auto access = server.NewStub<v1::AccessService>();
  v1::CreateTokenRequest wanted;
  wanted.mutable_token()->set_role(v1::ROLE_READER);
  const auto token = Ask(*access, &Access::CreateToken, wanted).response.token();
  Ask(*access, &Access::RevokeToken, Named<v1::RevokeTokenRequest>(token.name()));
  const auto databases = server.NewStub<v1::DatabaseService>();
  Ask(*databases, &v1::DatabaseService::Stub::DeleteDatabase,
      Named<v1::DeleteDatabaseRequest>("databases/none"));
  Ask(*databases, &v1::DatabaseService::Stub::DeleteDatabase,
      Named<v1::DeleteDatabaseRequest>("databases/walks"));

  const auto entries = Audit(server);
  CHECK(Lines(entries) == std::vector<std::string>{
                              "anonymous DatabaseService.CreateDatabase databases/walks -> 0",
                              "anonymous ClipService.IngestClip databases/walks/clips/walk -> 0",
                              "anonymous ClipService.DeleteClip databases/walks/clips/walk -> 0",
                              "anonymous OperationService.CancelOperation " + operation + " -> 0",
                              "anonymous AccessService.CreateToken " + token.name() + " -> 0",
                              "anonymous AccessService.RevokeToken " + token.name() + " -> 0",
                              "anonymous DatabaseService.DeleteDatabase databases/none -> 5",
                              "anonymous DatabaseService.DeleteDatabase databases/walks -> 0"});
  for (const auto& entry : entries) {
    CHECK(entry.peer() == "127.0.0.1");
    CHECK(entry.request_id().size() == 16);
    CHECK(entry.time().seconds() > 1'700'000'000);
  }
  // Survives a restart, and pages have the same entries.
  server.Restart();
  CHECK(Lines(Audit(server, "", 3)) == Lines(entries));
}

TEST_CASE("Audit: refused attempts name the caller", "[security][rpc]") {
  TestServer server;
  server.CreateDatabase("walks");
  const auto reader = NewToken(server, v1::ROLE_READER);
  const auto admin = NewToken(server, v1::ROLE_ADMIN);
  RequireTokens(server);

  const auto request = Named<v1::DeleteDatabaseRequest>("databases/walks");
  const auto databases = server.NewStub<v1::DatabaseService>();
  for (const std::string& token : {std::string(), reader.secret(), admin.secret()}) {
    Ask(*databases, &v1::DatabaseService::Stub::DeleteDatabase, request, token);
  }
  const auto lines = Lines(Audit(server, admin.secret()));
  REQUIRE(lines.size() == 6);
  const std::string call = " DatabaseService.DeleteDatabase databases/walks -> ";
  CHECK(lines[3] == "anonymous" + call + std::to_string(StatusCode::UNAUTHENTICATED));
  CHECK(lines[4] == reader.token().name() + call + std::to_string(StatusCode::PERMISSION_DENIED));
  CHECK(lines[5] == admin.token().name() + call + "0");
}

// Returns the number of entries of CancelOperation.
int CountCancelEntries(const std::vector<v1::AuditEntry>& entries) {
  return static_cast<int>(
      std::ranges::count(entries, "OperationService.CancelOperation", &v1::AuditEntry::method));
}

TEST_CASE("Audit: cancelling ended operations does not displace entries", "[security][rpc]") {
  server::ServerOptions options;
  options.engine.rebuild_delay = options.engine.rebuild_delay_limit = std::chrono::minutes(2);
  TestServer server(options);
  server.CreateDatabase("walks");
  const std::string operation = server.IngestFigure("walks", "walk", "walk", {}).operation().name();
  const std::string ingester = NewToken(server, v1::ROLE_INGESTER).secret();
  const std::string admin = NewToken(server, v1::ROLE_ADMIN).secret();
  RequireTokens(server);
  const auto operations = server.NewStub<v1::OperationService>();
  const auto cancel = [&](const std::string& name) {
    return Ask(*operations, &v1::OperationService::Stub::CancelOperation,
               Named<v1::CancelOperationRequest>(name), ingester);
  };
  for (int i = 0; i < 51; ++i) {
    const auto cancelled = cancel(operation);
    REQUIRE(cancelled.status.ok());
    REQUIRE(cancelled.response.operation().state() == v1::OPERATION_STATE_CANCELLED);
  }
  CHECK(CountCancelEntries(Audit(server, admin)) == 11);

  // A real change is still recorded.
  const auto clips = server.NewStub<v1::ClipService>();
  const auto deleted = Ask(*clips, &v1::ClipService::Stub::DeleteClip,
                           Named<v1::DeleteClipRequest>("databases/walks/clips/walk"), ingester);
  REQUIRE(deleted.status.ok());
  REQUIRE(cancel(deleted.response.operation().name()).status.ok());
  CHECK(CountCancelEntries(Audit(server, admin)) == 12);
}

// Reads a backup to its end, or cancels it after the first block.
grpc::Status Backup(TestServer& server, bool read_all, const std::string& token = "") {
  const auto stub = server.NewStub<v1::StoreService>();
  grpc::ClientContext context;
  if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
  const auto stream = stub->BackupStore(&context, {});
  v1::BackupStoreResponse block;
  while (stream->Read(&block)) {
    if (!read_all) context.TryCancel();
  }
  return stream->Finish();
}

TEST_CASE("Audit: backups are recorded, also refused and cancelled ones", "[security][rpc]") {
  TestServer server;
  server.CreateDatabase("walks");
  // More than the buffers between the server and a client that does not read.
  v1::IngestClipHeader header;
  header.set_parent("databases/walks");
  header.set_file_name("walk.bvh");
  REQUIRE(server.Ingest(header, WriteBvh({}) + std::string(std::size_t{12} << 20, '\n')).ok());
  const auto ingester = NewToken(server, v1::ROLE_INGESTER);
  const auto admin = NewToken(server, v1::ROLE_ADMIN);
  RequireTokens(server);
  const std::size_t before = Audit(server, admin.secret()).size();

  CHECK(Backup(server, true, ingester.secret()).error_code() == StatusCode::PERMISSION_DENIED);
  CHECK(Backup(server, true, admin.secret()).ok());
  CHECK(Backup(server, false, admin.secret()).error_code() == StatusCode::CANCELLED);
  std::vector<v1::AuditEntry> entries;
  do {  // the server may notice the cancellation later
    entries = Audit(server, admin.secret());
  } while (entries.size() < before + 3);
  const std::string call = " StoreService.BackupStore  -> ";
  const auto lines = Lines({entries.begin(), entries.begin() + 3});
  CHECK(lines[0] == ingester.token().name() + call + std::to_string(StatusCode::PERMISSION_DENIED));
  CHECK(lines[1] == admin.token().name() + call + "0");
  CHECK(lines[2] == admin.token().name() + call + std::to_string(StatusCode::CANCELLED));
  CHECK(entries.front().peer() == "127.0.0.1");
}

}  // namespace
}  // namespace motiondb::tests::audit_test
