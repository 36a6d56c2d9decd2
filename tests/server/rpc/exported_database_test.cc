// ExportDatabase and ImportDatabase of real servers.
#include <catch2/catch.hpp>
#include <functional>
#include <regex>
#include <string>
#include <vector>

#include "motiondb/v1/access.grpc.pb.h"
#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/edit.grpc.pb.h"
#include "motiondb/v1/model.grpc.pb.h"
#include "motiondb/v1/operation.grpc.pb.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "motiondb/v1/segment.grpc.pb.h"
#include "motiondb/v1/store.grpc.pb.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::exported_database_test {
namespace {

using grpc::StatusCode;

struct ExportedFile {
  grpc::Status status;
  std::string bytes;
};

ExportedFile Export(TestServer& server, const std::string& database) {
  grpc::ClientContext context;
  v1::ExportDatabaseRequest request;
  request.set_name("databases/" + database);
  const auto stub = server.NewStub<v1::StoreService>();
  const auto reader = stub->ExportDatabase(&context, request);
  ExportedFile file;
  std::int64_t total = 0;
  v1::ExportDatabaseResponse message;
  while (reader->Read(&message)) {
    if (message.total_bytes() > 0) total = message.total_bytes();
    CHECK(message.block().size() <= 1 << 20);
    file.bytes += message.block();
  }
  file.status = reader->Finish();
  if (file.status.ok()) CHECK(static_cast<std::int64_t>(file.bytes.size()) == total);
  return file;
}

Answer<v1::ImportDatabaseResponse> Import(TestServer& server, const std::string& bytes,
                                          const std::string& id = "", std::size_t block = 100'000) {
  Answer<v1::ImportDatabaseResponse> answer;
  grpc::ClientContext context;
  const auto stub = server.NewStub<v1::StoreService>();
  const auto writer = stub->ImportDatabase(&context, &answer.response);
  v1::ImportDatabaseRequest message;
  message.set_database_id(id);
  for (std::size_t begin = 0; begin < bytes.size(); begin += block) {
    message.set_block(bytes.substr(begin, block));
    if (!writer->Write(message)) break;
    message.clear_database_id();
  }
  writer->WritesDone();
  answer.status = writer->Finish();
  return answer;
}

void CheckRefused(const grpc::Status& status, StatusCode code, const std::string& text) {
  INFO(status.error_message());
  CHECK(status.error_code() == code);
  CHECK(status.error_message().find(text) != std::string::npos);
}

std::vector<std::string> Databases(TestServer& server) {
  const auto stub = server.NewStub<v1::DatabaseService>();
  const auto listed = Ask(*stub, &v1::DatabaseService::Stub::ListDatabases, {});
  REQUIRE(listed.status.ok());
  std::vector<std::string> names;
  for (const auto& database : listed.response.databases()) names.push_back(database.name());
  return names;
}

// Everything that a client sees of a database, under the name "databases/*".
std::string Seen(TestServer& server, const std::string& database) {
  std::string text;
  const auto add = [&](const auto& answer) {
    INFO(answer.status.error_message());
    REQUIRE(answer.status.ok());
    text += answer.response.DebugString();
  };
  const std::string name = "databases/" + database;
  const auto clips = server.NewStub<v1::ClipService>();
  v1::ListClipsRequest list;
  list.set_parent(name);
  add(Ask(*clips, &v1::ClipService::Stub::ListClips, list));
  v1::SearchClipsRequest search;
  search.set_parent(name);
  search.set_query("wav*");
  auto found = Ask(*clips, &v1::ClipService::Stub::SearchClips, search);
  for (auto& match : *found.response.mutable_matches()) match.clear_score();
  add(found);
  v1::ListSegmentsRequest segments;
  segments.set_parent(name);
  add(Ask(*server.NewStub<v1::SegmentService>(), &v1::SegmentService::Stub::ListSegments,
          segments));
  v1::ListEditsRequest edits;
  edits.set_parent(name);
  add(Ask(*server.NewStub<v1::EditService>(), &v1::EditService::Stub::ListEdits, edits));
  v1::ListModelsRequest models;
  models.set_parent(name);
  add(Ask(*server.NewStub<v1::ModelService>(), &v1::ModelService::Stub::ListModels, models));
  v1::RecognizeRequest recognize;
  recognize.set_database(name);
  *recognize.mutable_observation() = WalkObservation();
  add(Ask(*server.NewStub<v1::QueryService>(), &v1::QueryService::Stub::Recognize, recognize));
  return std::regex_replace(text, std::regex(name + "([/\"])"), "databases/*$1");
}

// A server with the trained database "db", an edited segment and another database.
struct Filled {
  TestServer server;

  Filled() {
    server.CreateTrained("db");
    server.CreateDatabase("other");
    v1::CreateSegmentRequest request;
    request.set_parent("databases/db/clips/wave");
    request.mutable_segment()->set_track("carries");
    request.mutable_segment()->set_label("box");
    request.mutable_segment()->set_end_seconds(0.5);
    const auto created = Ask(*server.NewStub<v1::SegmentService>(),
                             &v1::SegmentService::Stub::CreateSegment, request);
    REQUIRE(created.status.ok());
    if (!created.response.operation().name().empty()) {
      REQUIRE(IsDone(server.Wait(created.response.operation().name())));
    }
  }
};

TEST_CASE("ImportDatabase: the database looks like the exported one, without a rebuild",
          "[server][rpc]") {
  Filled filled;
  TestServer& server = filled.server;
  const std::string seen = Seen(server, "db");
  const ExportedFile file = Export(server, "db");
  INFO(file.status.error_message());
  REQUIRE(file.status.ok());

  const auto copied = Import(server, file.bytes, "copy");
  INFO(copied.status.error_message());
  REQUIRE(copied.status.ok());
  CHECK(copied.response.name() == "databases/copy");
  CHECK(copied.response.clip_count() == 3);
  CHECK(Seen(server, "copy") == seen);
  v1::ListOperationsRequest operations;
  operations.set_parent("databases/copy");
  const auto listed = Ask(*server.NewStub<v1::OperationService>(),
                          &v1::OperationService::Stub::ListOperations, operations);
  REQUIRE(listed.status.ok());
  CHECK(listed.response.operations().empty());

  TestServer fresh;
  REQUIRE(Import(fresh, file.bytes).status.ok());
  CHECK(Databases(fresh) == std::vector<std::string>{"databases/db"});
  CHECK(Seen(fresh, "db") == seen);
  fresh.Restart();
  CHECK(Seen(fresh, "db") == seen);
  // It takes new clips, and becomes another database than the original.
  const auto next = fresh.IngestFigure("db", "late", "walk", {.phase = 0.4});
  CHECK(fresh.Wait(next.operation().name()).state() == v1::OPERATION_STATE_SUCCEEDED);
  CHECK(fresh.Describe("db").stored_clip_count() == 4);
  CHECK(server.Describe("db").stored_clip_count() == 3);
}

TEST_CASE("ImportDatabase: errors change nothing", "[server][rpc]") {
  Filled filled;
  TestServer& server = filled.server;
  const std::string bytes = Export(server, "db").bytes;
  const auto before = Databases(server);

  CheckRefused(Export(server, "none").status, StatusCode::NOT_FOUND, "'none'");
  CheckRefused(Import(server, bytes).status, StatusCode::ALREADY_EXISTS, "'db' already exists");
  CheckRefused(Import(server, bytes, "db").status, StatusCode::ALREADY_EXISTS, "'db'");
  CheckRefused(Import(server, bytes, "a/b").status, StatusCode::INVALID_ARGUMENT, "database_id");
  CheckRefused(Import(server, "").status, StatusCode::INVALID_ARGUMENT, "is empty");
  CheckRefused(Import(server, std::string(1000, 'x'), "new").status, StatusCode::INVALID_ARGUMENT,
               "not a backup");
  CheckRefused(Import(server, bytes.substr(0, bytes.size() / 2), "new").status,
               StatusCode::INVALID_ARGUMENT, "cut off");
  CheckRefused(Import(server, bytes, "new", (1 << 20) + 1).status, StatusCode::INVALID_ARGUMENT,
               "expected at most 1048576 bytes");
  std::string changed = bytes;
  changed[changed.size() / 2] ^= 1;
  CheckRefused(Import(server, changed, "new").status, StatusCode::INVALID_ARGUMENT, "checksum");
  CHECK(Databases(server) == before);

  // A backup of the store has two databases.
  grpc::ClientContext context;
  const auto reader = server.NewStub<v1::StoreService>()->BackupStore(&context, {});
  std::string backup;
  v1::BackupStoreResponse block;
  while (reader->Read(&block)) backup += block.block();
  REQUIRE(reader->Finish().ok());
  CheckRefused(Import(server, backup, "new").status, StatusCode::INVALID_ARGUMENT,
               "the file has 2 databases");
  CHECK(Databases(server) == before);
}

TEST_CASE("ImportDatabase: quotas hold", "[server][rpc]") {
  std::string bytes;
  {
    Filled filled;
    bytes = Export(filled.server, "db").bytes;
  }
  const auto [limit,
              setting] = GENERATE(table<std::function<void(server::EngineOptions&)>, std::string>({
      {[](server::EngineOptions& engine) { engine.max_databases = 1; }, "--max-databases"},
      {[](server::EngineOptions& engine) { engine.quota.clip_count = 2; }, "--max-database-clips"},
      {[](server::EngineOptions& engine) { engine.quota.frame_count = 100; },
       "--max-database-frames"},
      {[](server::EngineOptions& engine) { engine.quota.byte_count = 10'000; },
       "--max-database-mib"},
  }));
  server::ServerOptions options;
  options.listen = "127.0.0.1:0";
  limit(options.engine);
  TestServer server(options);
  server.CreateDatabase("first");
  CheckRefused(Import(server, bytes, "new").status, StatusCode::RESOURCE_EXHAUSTED, setting);
  CHECK(Databases(server).size() == 1);
}

TEST_CASE("ImportDatabase: a name in a later message is refused", "[server][rpc]") {
  TestServer server;
  grpc::ClientContext context;
  v1::ImportDatabaseResponse response;
  const auto writer = server.NewStub<v1::StoreService>()->ImportDatabase(&context, &response);
  v1::ImportDatabaseRequest message;
  message.set_database_id("a");
  message.set_block("SQLite format 3");
  writer->Write(message);
  writer->Write(message);
  writer->WritesDone();
  CheckRefused(writer->Finish(), StatusCode::INVALID_ARGUMENT, "only in the first message");
}

TEST_CASE("ExportDatabase and ImportDatabase are recorded in the audit log", "[server][rpc]") {
  Filled filled;
  TestServer& server = filled.server;
  const std::string bytes = Export(server, "db").bytes;
  REQUIRE(Import(server, bytes, "copy").status.ok());
  CheckRefused(Import(server, bytes, "copy").status, StatusCode::ALREADY_EXISTS, "");
  const auto listed =
      Ask(*server.NewStub<v1::AccessService>(), &v1::AccessService::Stub::ListAuditEntries, {});
  REQUIRE(listed.status.ok());
  REQUIRE(listed.response.entries_size() >= 3);
  const auto line = [&](int i) {
    const auto& entry = listed.response.entries(i);
    return entry.method() + " " + entry.resource() + " " + std::to_string(entry.code());
  };
  CHECK(line(0) == "StoreService.ImportDatabase  6");
  CHECK(line(1) == "StoreService.ImportDatabase databases/copy 0");
  CHECK(line(2) == "StoreService.ExportDatabase databases/db 0");
}

}  // namespace
}  // namespace motiondb::tests::exported_database_test
