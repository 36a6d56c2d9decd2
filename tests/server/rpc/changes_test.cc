// Calls that change the store: they wait for the writer, and other calls do not wait for them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "motiondb/v1/access.grpc.pb.h"
#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "server/security/authorize.h"
#include "tests/server/rpc/limited_server.h"
#include "tests/storage/samples.h"
#include "tests/storage/while_writing.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::changes_test {
namespace {

TEST_CASE("Role table: a change of the store never waits for the writer on a thread of queries",
          "[server][limits]") {
  int changes = 0;
  int urgent = 0;
  for (const server::CallRule& rule : server::CallRules()) {
    CAPTURE(rule.method);
    const bool light = rule.request_class == server::RequestClass::kLight;
    CHECK_FALSE((rule.recorded && light && rule.pool == server::Pool::kRequests));
    const bool is_change = rule.pool == server::Pool::kChanges;
    CHECK((!is_change || (light && rule.recorded)));
    CHECK((!rule.urgent || is_change));
    changes += is_change ? 1 : 0;
    urgent += rule.urgent ? 1 : 0;
  }
  CHECK(changes == 15);
  CHECK(urgent == 2);
  // A stolen token must not stay valid while other changes wait.
  CHECK(server::FindCallRule("AccessService.RevokeToken")->urgent);
}

// Returns whether posted work runs within a time that suits a slow machine.
template <typename Post>
bool RunsSoon(const Post& post) {
  const auto done = std::make_shared<std::promise<void>>();
  post([done] { done->set_value(); });
  return done->get_future().wait_for(std::chrono::minutes(1)) == std::future_status::ready;
}

TEST_CASE("Limits: a change that waits for its turn delays no query and holds no thread for long",
          "[server][limits]") {
  server::ServerOptions options = With({});
  options.engine.query_threads = 1;
  TestServer server(options);
  server.CreateTrained("db");
  server::Engine& engine = server.server().engine();
  const auto databases = server.NewStub<v1::DatabaseService>();
  const auto create = [&](const std::string& id, std::chrono::milliseconds time) {
    v1::CreateDatabaseRequest request;
    request.set_database_id(id);
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + time);
    v1::CreateDatabaseResponse response;
    return databases->CreateDatabase(&context, request, &response);
  };
  std::vector<std::future<grpc::Status>> waiting;
  REQUIRE(engine.store().CreateDatabase(SampleDatabase("d")).ok());
  WithBlockedWriter(engine.store(), SampleClip("d", "holder", 1), [&] {
    CHECK(create("late", std::chrono::seconds(2)).error_code() ==
          grpc::StatusCode::DEADLINE_EXCEEDED);
    // The next change has its turn, and the thread for queries was free all the time. Later changes
    // wait for the store; other calls do not.
    for (const char* const id : {"in-time", "too"}) {
      waiting.push_back(
          std::async(std::launch::async, [&, id] { return create(id, std::chrono::minutes(1)); }));
    }
    CHECK(RunsSoon([&](auto work) { engine.workers().Post(server::Pool::kChanges, work); }));
    v1::IngestClipHeader nowhere;
    nowhere.set_parent("databases/none");
    nowhere.set_file_name("walk.bvh");
    CHECK(server.Ingest(nowhere, "x").error_code() == grpc::StatusCode::NOT_FOUND);
    v1::GetDatabaseRequest get;
    get.set_name("databases/db");
    CHECK(Ask(*databases, &v1::DatabaseService::Stub::GetDatabase, get).status.ok());
  });
  for (auto& each : waiting) CHECK(each.get().ok());
  // A change without effect also has an audit entry.
  CHECK(RunsSoon([&](auto work) { engine.workers().Post(server::Pool::kMaintenance, work); }));
  const auto records = engine.store().access().ListAuditRecords(0, 10);
  REQUIRE(records.ok());
  for (const char* const resource : {"databases/late", "databases/none"}) {
    const auto found = std::ranges::find(*records, resource, &storage::AuditRecord::resource);
    REQUIRE(found != records->end());
    CHECK(found->code != 0);
  }
  CHECK_FALSE(engine.FindDatabase("late").ok());
  CHECK(engine.FindDatabase("in-time").ok());
}

TEST_CASE("Audit: an edit without effect has one entry, as the edit before it",
          "[server][limits]") {
  TestServer server;
  server.CreateTrained("db");
  v1::UpdateClipRequest request;
  request.mutable_clip()->set_name("databases/db/clips/walk");
  request.mutable_clip()->set_title("Walk");
  request.mutable_update_mask()->add_paths("title");
  const auto clips = server.NewStub<v1::ClipService>();
  for (int i = 0; i < 2; ++i) {
    REQUIRE(Ask(*clips, &v1::ClipService::Stub::UpdateClip, request).status.ok());
  }
  const auto records = server.server().engine().store().access().ListAuditRecords(0, 20);
  REQUIRE(records.ok());
  CHECK(std::ranges::count_if(*records, [](const storage::AuditRecord& record) {
          return record.method.find("UpdateClip") != std::string::npos && record.code == 0;
        }) == 2);
}

}  // namespace
}  // namespace motiondb::tests::changes_test
