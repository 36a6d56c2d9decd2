#include <catch2/catch.hpp>
#include <limits>

#include "motiondb/v1/database.grpc.pb.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::database_service_test {
namespace {

using Stub = v1::DatabaseService::Stub;

Answer<v1::CreateDatabaseResponse> Create(Stub& stub, const std::string& id,
                                          const v1::Database& database = {}) {
  v1::CreateDatabaseRequest request;
  request.set_database_id(id);
  *request.mutable_database() = database;
  return Ask(stub, &Stub::CreateDatabase, request);
}

Answer<v1::GetDatabaseResponse> Get(Stub& stub, const std::string& name) {
  v1::GetDatabaseRequest request;
  request.set_name(name);
  return Ask(stub, &Stub::GetDatabase, request);
}

TEST_CASE("DatabaseService: a new database has the defaults", "[server][rpc]") {
  TestServer server;
  const auto stub = server.NewStub<v1::DatabaseService>();
  const auto created = Create(*stub, "walks");
  INFO(created.status.error_message());
  REQUIRE(created.status.ok());
  const v1::Database& database = created.response.database();
  CHECK(database.name() == "databases/walks");
  CHECK(database.frame_rate_hz() == 60);
  CHECK(database.min_frames() == 16);
  CHECK(database.scaling() == v1::SCALING_KIND);
  CHECK(database.marker_set() == "standard34");
  CHECK(database.marker_names_size() == 34);
  CHECK(database.marker_set_file().empty());
  CHECK(database.create_time().seconds() > 1'700'000'000);
  CHECK(database.model_version() == 0);
  const auto got = Get(*stub, "databases/walks");
  REQUIRE(got.status.ok());
  CHECK(got.response.database().SerializeAsString() == database.SerializeAsString());
}

TEST_CASE("DatabaseService: a call that waits for the model fills its response once",
          "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const int markers = Get(*server.NewStub<v1::DatabaseService>(), "databases/db")
                          .response.database()
                          .marker_names_size();
  REQUIRE(markers > 0);
  server.Stop();
  server.options().engine.model_memory_bytes = 1;  // the model is read when it is used
  server.Start();
  v1::GetDatabaseRequest request;
  request.set_name("databases/db");
  request.set_view(v1::DATABASE_VIEW_FULL);
  const auto got = Ask(*server.NewStub<v1::DatabaseService>(), &Stub::GetDatabase, request);
  REQUIRE(got.status.ok());
  CHECK(got.response.database().marker_names_size() == markers);
  CHECK(got.response.database().statistics().clip_count() == 3);
}

TEST_CASE("DatabaseService: given settings are stored", "[server][rpc]") {
  TestServer server;
  const auto stub = server.NewStub<v1::DatabaseService>();
  v1::Database settings;
  settings.set_frame_rate_hz(120);
  settings.set_min_frames(8);
  settings.set_scaling(v1::SCALING_NONE);
  settings.set_glitches(v1::GLITCHES_DROP);
  settings.set_marker_set("source");
  settings.set_clip_count(99);  // output only: ignored
  const auto created = Create(*stub, "a", settings);
  REQUIRE(created.status.ok());
  CHECK(created.response.database().frame_rate_hz() == 120);
  CHECK(created.response.database().min_frames() == 8);
  CHECK(created.response.database().scaling() == v1::SCALING_NONE);
  CHECK(created.response.database().glitches() == v1::GLITCHES_DROP);
  CHECK(created.response.database().marker_names().empty());
  CHECK(created.response.database().clip_count() == 0);
}

TEST_CASE("DatabaseService: the error names the invalid setting", "[server][rpc]") {
  TestServer server;
  const auto stub = server.NewStub<v1::DatabaseService>();
  const auto expect = [&](const std::string& field, const auto& change) {
    v1::Database settings;
    change(settings);
    const auto created = Create(*stub, "a", settings);
    INFO(field << ": " << created.status.error_message());
    CHECK(created.status.error_code() == grpc::StatusCode::INVALID_ARGUMENT);
    CHECK(ViolatedFields(created.status) == field);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect("database.frame_rate_hz", [&](auto& d) { d.set_frame_rate_hz(nan); });
  expect("database.frame_rate_hz", [&](auto& d) { d.set_frame_rate_hz(-60); });
  expect("database.frame_rate_hz", [&](auto& d) { d.set_frame_rate_hz(1e9); });
  expect("database.min_frames", [&](auto& d) { d.set_min_frames(-1); });
  expect("database.min_frames", [&](auto& d) { d.set_min_frames(1); });
  expect("database.scaling", [&](auto& d) { d.set_scaling(static_cast<v1::Scaling>(9)); });
  expect("database.glitches", [&](auto& d) { d.set_glitches(static_cast<v1::Glitches>(9)); });
  expect("database.marker_set", [&](auto& d) { d.set_marker_set("mine"); });
  expect("database.marker_set_file", [&](auto& d) { d.set_marker_set_file("not a marker set"); });
  for (const char* id : {"", "A", "-a", "a/b"}) {
    const auto created = Create(*stub, id);
    CHECK(created.status.error_code() == grpc::StatusCode::INVALID_ARGUMENT);
    CHECK(ViolatedFields(created.status) == "database_id");
  }
}

TEST_CASE("DatabaseService: names in use, unknown names and invalid names", "[server][rpc]") {
  TestServer server;
  const auto stub = server.NewStub<v1::DatabaseService>();
  REQUIRE(Create(*stub, "a").status.ok());
  CHECK(Create(*stub, "a").status.error_code() == grpc::StatusCode::ALREADY_EXISTS);
  CHECK(Get(*stub, "databases/b").status.error_code() == grpc::StatusCode::NOT_FOUND);
  CHECK(ViolatedFields(Get(*stub, "b").status) == "name");
  v1::DeleteDatabaseRequest request;
  request.set_name("databases/a");
  CHECK(Ask(*stub, &Stub::DeleteDatabase, request).status.ok());
  CHECK(Ask(*stub, &Stub::DeleteDatabase, request).status.error_code() ==
        grpc::StatusCode::NOT_FOUND);
  CHECK(Create(*stub, "a").status.ok());
}

TEST_CASE("DatabaseService: ReprocessDatabase derives clips again", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  server.Wait(server.IngestFigure("db", "walk", "walk", {}).operation().name());
  const auto stub = server.NewStub<v1::DatabaseService>();
  v1::ReprocessDatabaseRequest request;
  request.set_name("databases/db");
  const auto asked = Ask(*stub, &Stub::ReprocessDatabase, request);
  INFO(asked.status.error_message());
  REQUIRE(asked.status.ok());
  CHECK(asked.response.operation().database() == "databases/db");
  CHECK(asked.response.operation().kind() == v1::OPERATION_KIND_REPROCESS);
  const auto done = server.Wait(asked.response.operation().name());
  CHECK(done.state() == v1::OPERATION_STATE_SUCCEEDED);
  CHECK_THAT(done.stage(), Catch::Contains("clips derived again: 1"));
  CHECK(server.Describe("db").underived_clip_count() == 0);
  request.set_name("databases/none");
  CHECK(Ask(*stub, &Stub::ReprocessDatabase, request).status.error_code() ==
        grpc::StatusCode::NOT_FOUND);
  request.set_name("db");
  CHECK(ViolatedFields(Ask(*stub, &Stub::ReprocessDatabase, request).status) == "name");
}

TEST_CASE("DatabaseService: lists in order, page by page", "[server][rpc]") {
  TestServer server;
  const auto stub = server.NewStub<v1::DatabaseService>();
  for (const char* id : {"c", "a", "e", "d", "b"}) REQUIRE(Create(*stub, id).status.ok());
  v1::ListDatabasesRequest request;
  request.set_page_size(2);
  std::string names;
  int pages = 0;
  do {
    const auto page = Ask(*stub, &Stub::ListDatabases, request);
    REQUIRE(page.status.ok());
    for (const auto& database : page.response.databases()) names += database.name().back();
    request.set_page_token(page.response.next_page_token());
    ++pages;
  } while (!request.page_token().empty());
  CHECK(names == "abcde");
  CHECK(pages == 3);
  request.set_page_token("nonsense");
  CHECK(ViolatedFields(Ask(*stub, &Stub::ListDatabases, request).status) == "page_token");
  request.Clear();
  request.set_page_size(-1);
  CHECK(ViolatedFields(Ask(*stub, &Stub::ListDatabases, request).status) == "page_size");
}

TEST_CASE("DatabaseService: the revision grows with each change", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  server.CreateDatabase("other");
  const auto stub = server.NewStub<v1::DatabaseService>();
  const auto before = Get(*stub, "databases/db").response.database().revision();
  CHECK(before == 0);  // as the answer of CreateDatabase
  server.Wait(server.IngestFigure("db", "walk", "walk", {.frame_count = 60}).operation().name());
  const auto after = Get(*stub, "databases/db").response.database().revision();
  CHECK(after > before);
  const auto listed = Ask(*stub, &Stub::ListDatabases, v1::ListDatabasesRequest()).response;
  REQUIRE(listed.databases_size() == 2);
  CHECK(listed.databases(0).revision() == after);
  CHECK(listed.databases(1).revision() == before);
}

TEST_CASE("DatabaseService: the view decides whether there are statistics", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  const auto stub = server.NewStub<v1::DatabaseService>();
  v1::GetDatabaseRequest request;
  request.set_name("databases/db");
  for (const v1::DatabaseView view : {v1::DATABASE_VIEW_UNSPECIFIED, v1::DATABASE_VIEW_BASIC}) {
    request.set_view(view);
    CHECK(!Ask(*stub, &Stub::GetDatabase, request).response.database().has_statistics());
  }
  request.set_view(v1::DATABASE_VIEW_FULL);
  const auto full = Ask(*stub, &Stub::GetDatabase, request).response.database();
  CHECK(full.statistics().name() == full.name());
  request.set_view(static_cast<v1::DatabaseView>(7));
  CHECK(ViolatedFields(Ask(*stub, &Stub::GetDatabase, request).status) == "view");
}

TEST_CASE("DatabaseService: statistics describe the model", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  CHECK(server.Describe("db").model_version() == 0);
  CHECK(server.Describe("db").frame_rate_hz() == 60);
  server.CreateTrained("trained");
  const auto described = server.Describe("trained");
  CHECK(described.name() == "databases/trained");
  CHECK(described.frame_count() == 360);
  CHECK(described.clip_count() == 3);
  CHECK(described.stored_clip_count() == 3);
  CHECK(described.model_version() == 1);
  CHECK(described.build_seconds() > 0);
  CHECK(described.dimension_count() == 60);
  REQUIRE(described.layer_count() > 2);
  REQUIRE(described.nodes_per_layer_size() == described.layer_count());
  CHECK(described.nodes_per_layer(0) == 1);
  CHECK(described.bottom_node_count() == described.nodes_per_layer(described.layer_count() - 1));
  int nodes = 0;
  for (const int count : described.nodes_per_layer()) nodes += count;
  CHECK(described.node_count() == nodes);
  REQUIRE(described.labels_size() == 3);
  CHECK(described.labels(0).label() == "squat");
  CHECK(described.labels(0).clip_count() == 1);
  CHECK(described.labels(0).frame_count() == 120);
}

}  // namespace
}  // namespace motiondb::tests::database_service_test
