// The database that calls name in their metadata, for proxies.
#include "client/routing.h"

#include <motiondb/client.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/operation.pb.h>
#include <motiondb/v1/query.pb.h>
#include <motiondb/v1/segment.pb.h>
#include <motiondb/v1/store.pb.h>

#include <catch2/catch.hpp>

#include "tests/client/connect.h"
#include "tests/client/fake_server.h"
#include "tests/client/temporary_folder.h"

namespace motiondb::tests::routing_test {
namespace {

// The value of the metadata in the only call of `rpc`; "-" if there is none.
std::string Sent(const FakeServer& server, const std::string& rpc) {
  const auto calls = server.HeadersOf(rpc);
  REQUIRE(calls.size() == 1);
  const auto found = calls[0].find("motiondb-database");
  return found == calls[0].end() ? "-" : found->second;
}

TEST_CASE("Routing: the id of the database in a name", "[client]") {
  CHECK(client::DatabaseIdOf("databases/walks") == "walks");
  CHECK(client::DatabaseIdOf("databases/walks-2_a/clips/07_01") == "walks-2_a");
  CHECK(client::DatabaseIdOf("operations/7").empty());
  CHECK(client::DatabaseIdOf("").empty());
  CHECK(client::DatabaseIdOf("databases/").empty());
  // Such a value would not be valid metadata.
  CHECK(client::DatabaseIdOf("databases/Schritte \xC3\xA4\n").empty());
  CHECK(client::DatabaseIdOf("databases/" + std::string(64, 'a')).empty());
  v1::CreateDatabaseRequest create;
  create.set_database_id("walks");
  CHECK(client::DatabaseOf(create) == "walks");
  v1::UpdateClipRequest clip;
  clip.mutable_clip()->set_name("databases/walks/clips/a");
  CHECK(client::DatabaseOf(clip) == "walks");
  v1::UpdateSegmentRequest segment;
  segment.mutable_segment()->set_name("databases/walks/clips/a/segments/b");
  CHECK(client::DatabaseOf(segment) == "walks");
  v1::UploadClipRequest upload;
  upload.mutable_header()->set_parent("databases/walks");
  CHECK(client::DatabaseOf(upload) == "walks");
  CHECK(client::DatabaseOf(v1::ListDatabasesRequest()).empty());
}

TEST_CASE("Routing: calls of all kinds send the database", "[client]") {
  FakeServer server;
  const client::Client client = ConnectTo(server.address());
  v1::RecognizeRequest recognize;
  recognize.set_database("databases/walks");
  client.Recognize(recognize).status().IgnoreError();
  CHECK(Sent(server, "Recognize") == "walks");
  v1::ExportClipRequest export_clip;
  export_clip.set_name("databases/walks/clips/a");
  client.ExportClip(export_clip).status().IgnoreError();
  CHECK(Sent(server, "ExportClip") == "walks");
  v1::IngestClipHeader header;
  header.set_parent("databases/walks");
  client.IngestBytes(header, "motion").status().IgnoreError();
  CHECK(Sent(server, "IngestClip") == "walks");
  const TemporaryFolder folder;
  client.ImportDatabase(folder.Write("file", "bytes"), "walks").status().IgnoreError();
  CHECK(Sent(server, "ImportDatabase") == "walks");
  v1::WatchDatabaseRequest watch_request;
  watch_request.set_name("databases/walks");
  client::Watch watch = client.WatchDatabase(watch_request);
  v1::WatchDatabaseResponse change;
  CHECK(!watch.Next(change));
  CHECK(Sent(server, "WatchDatabase") == "walks");
  client.ListDatabases({}).status().IgnoreError();
  CHECK(Sent(server, "ListDatabases") == "-");
  v1::GetDatabaseRequest wrong;
  wrong.set_name("databases/\xC3\xA4 b\n");
  client.GetDatabase(wrong).status().IgnoreError();
  CHECK(Sent(server, "GetDatabase") == "-");
}

}  // namespace
}  // namespace motiondb::tests::routing_test
