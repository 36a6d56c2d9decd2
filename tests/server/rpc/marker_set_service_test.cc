#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "core/format/marker_set_file.h"
#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/marker_set.grpc.pb.h"
#include "tests/server/rpc/refusal.h"
#include "tests/support/stick_figure.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::marker_set_service_test {
namespace {

using Catch::Contains;
using grpc::StatusCode;
using Stub = v1::MarkerSetService::Stub;

// A small set, as in docs/file_formats.md. No file in this test has the joints of its mapping.
const std::string kLowerBody =
    "motiondb-marker-set 1\n"
    "name lower_body\n"
    "marker Pelvis\nmarker LHip\nmarker RHip\nmarker LKnee\nmarker RKnee\n"
    "marker LAnkle\nmarker RAnkle\n"
    "hips LHip RHip\n"
    "leg LHip LKnee LAnkle\nleg RHip RKnee RAnkle\n"
    "Pelvis = 0.5 LHip + 0.5 RHip\n"
    "mapping robot\n"
    "LHip = l_thigh\nRHip = r_thigh\nLKnee = l_shin\nRKnee = r_shin\n"
    "LAnkle = 0.9 l_foot + 0.1 l_shin\nRAnkle = 1 r_foot offset r_foot 0 -0.02 0\n";

// Returns a file with the mapping `odd` of the figure of OddWalk, whose ankles are made by `ankle`,
// for example "foot{0}", where {0} is the number of the side.
std::string OddMapping(const std::string& ankle = "foot{0}") {
  std::string text =
      "motiondb-marker-set 1\nextend lower_body\nmapping odd\n"
      "LHip = thigh1\nRHip = thigh2\nLKnee = shin1\nRKnee = shin2\n";
  text += "LAnkle = " + fmt::format(fmt::runtime(ankle), 1) + "\n";
  text += "RAnkle = " + fmt::format(fmt::runtime(ankle), 2) + "\n";
  return text;
}

// Returns a walk as BVH whose joints have names that no mapping of lower_body knows. Its legs are
// 0.42 m + 0.4 m long.
std::string OddWalk(double phase = 0) {
  std::string text = WriteBvh(Walk(phase));
  for (const auto& [from, to] :
       {std::pair<std::string_view, std::string_view>{"LeftUpLeg", "thigh1"},
        {"RightUpLeg", "thigh2"},
        {"LeftLeg", "shin1"},
        {"RightLeg", "shin2"},
        {"LeftFoot", "foot1"},
        {"RightFoot", "foot2"}}) {
    const auto at = text.find(from);
    REQUIRE(at != std::string::npos);
    text.replace(at, from.size(), to);
  }
  return text;
}

grpc::Status IngestOdd(TestServer& server, const std::string& name, double phase = 0,
                       v1::IngestClipResponse* response = nullptr) {
  v1::IngestClipHeader header;
  header.set_parent("databases/db");
  header.set_file_name(name + ".bvh");
  return server.Ingest(header, OddWalk(phase), response);
}

v1::IngestClipResponse IngestedOdd(TestServer& server, const std::string& name, double phase = 0) {
  v1::IngestClipResponse response;
  const grpc::Status status = IngestOdd(server, name, phase, &response);
  INFO(status.error_message());
  REQUIRE(status.ok());
  return response;
}

void CreateDatabase(TestServer& server, const std::string& id, const std::string& file) {
  v1::CreateDatabaseRequest request;
  request.set_database_id(id);
  request.mutable_database()->set_min_frames(4);
  request.mutable_database()->set_marker_set_file(file);
  const auto stub = server.NewStub<v1::DatabaseService>();
  const auto answer = Ask(*stub, &v1::DatabaseService::Stub::CreateDatabase, request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
}

Answer<v1::GetMarkerSetResponse> Get(TestServer& server, const std::string& database) {
  v1::GetMarkerSetRequest request;
  request.set_database(database);
  return Ask(*server.NewStub<v1::MarkerSetService>(), &Stub::GetMarkerSet, request);
}

Answer<v1::AddMappingsResponse> Add(TestServer& server, const std::string& database,
                                    const std::string& file) {
  v1::AddMappingsRequest request;
  request.set_database(database);
  request.set_mapping_file(file);
  return Ask(*server.NewStub<v1::MarkerSetService>(), &Stub::AddMappings, request);
}

grpc::Status Delete(TestServer& server, const std::string& database, const std::string& mapping) {
  v1::DeleteMappingRequest request;
  request.set_database(database);
  request.set_mapping(mapping);
  return Ask(*server.NewStub<v1::MarkerSetService>(), &Stub::DeleteMapping, request).status;
}

v1::MarkerSet MarkerSetOf(TestServer& server, const std::string& database = "databases/db") {
  auto answer = Get(server, database);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  return std::move(*answer.response.mutable_marker_set());
}

std::string MappingNames(const v1::MarkerSet& set) {
  std::string names;
  for (const auto& mapping : set.mappings()) names += mapping.name() + " ";
  return names;
}

// Returns the texts of the set as a marker-set file.
std::string WholeFile(const v1::MarkerSet& set) {
  std::string text = set.text();
  for (const auto& mapping : set.mappings()) text += mapping.text();
  return text;
}

// Returns the scheme in a marker-set file, in one form.
std::string Normalized(const std::string& text) {
  const auto scheme = core::ReadMarkerSetFile({"text", text});
  INFO(scheme.status());
  REQUIRE(scheme.ok());
  return core::WriteMarkerSetFile(*scheme);
}

double LegLength(TestServer& server, const std::string& clip) {
  v1::GetClipRequest request;
  request.set_name(clip);
  const auto stub = server.NewStub<v1::ClipService>();
  const auto answer = Ask(*stub, &v1::ClipService::Stub::GetClip, request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  return answer.response.clip().leg_length_m();
}

TEST_CASE("MarkerSetService: the texts of a set are its marker-set file", "[server][rpc]") {
  TestServer server;
  CreateDatabase(server, "standard", "");
  CreateDatabase(server, "db", kLowerBody);
  const std::string standard = core::WriteMarkerSetFile(core::StandardScheme());
  for (const char* database : {"", "databases/standard"}) {
    const v1::MarkerSet set = MarkerSetOf(server, database);
    CHECK(set.name() == "standard34");
    CHECK(set.marker_names_size() == 34);
    CHECK(set.mappings_size() == std::ssize(core::StandardScheme().mappings));
    CHECK(Normalized(WholeFile(set)) == standard);
  }
  const v1::MarkerSet lower = MarkerSetOf(server);
  CHECK(lower.name() == "lower_body");
  REQUIRE(lower.marker_names_size() == 7);
  CHECK(lower.marker_names(0) == "Pelvis");
  CHECK(lower.marker_names(6) == "RAnkle");
  REQUIRE(MappingNames(lower) == "robot ");
  CHECK(lower.mappings(0).signature_size() == 6);
  CHECK(lower.mappings(0).signature(0) == "l_foot");
  CHECK(Normalized(WholeFile(lower)) == Normalized(kLowerBody));
}

TEST_CASE("MarkerSetService: files that only an added mapping fits can be ingested",
          "[server][rpc]") {
  TestServer server;
  CreateDatabase(server, "db", kLowerBody);
  const grpc::Status before = IngestOdd(server, "walk");
  CHECK(before.error_code() == StatusCode::INVALID_ARGUMENT);
  CHECK_THAT(before.error_message(), Contains("'robot'"));

  const auto added = Add(server, "databases/db", OddMapping());
  INFO(added.status.error_message());
  REQUIRE(added.status.ok());
  REQUIRE(added.response.mappings_size() == 1);
  CHECK(added.response.mappings(0).name() == "odd");
  CHECK(added.response.mappings(0).signature_size() == 6);
  // Also the rule that the file left to a default rule.
  CHECK_THAT(added.response.mappings(0).text(), Contains("Pelvis = 0.5 thigh1 + 0.5 thigh2"));
  CHECK(MappingNames(MarkerSetOf(server)) == "odd robot ");
  CHECK(MarkerSetOf(server).mappings(0).SerializeAsString() ==
        added.response.mappings(0).SerializeAsString());
  CHECK(IngestedOdd(server, "walk").clip().leg_length_m() == Approx(0.82).epsilon(1e-3));

  // The order of a file's mappings stays.
  REQUIRE(Add(server, "databases/db",
              OddMapping() + "mapping next\nLHip = a\nRHip = b\nLKnee = c\nRKnee = d\n"
                             "LAnkle = e\nRAnkle = f\n")
              .status.ok());
  CHECK(MappingNames(MarkerSetOf(server)) == "odd next robot ");

  const std::string text = WholeFile(MarkerSetOf(server));
  server.Restart();
  CHECK(WholeFile(MarkerSetOf(server)) == text);
  CHECK(IngestOdd(server, "again", 1).ok());
}

TEST_CASE("MarkerSetService: a mapping is replaced by one with its name", "[server][rpc]") {
  TestServer server;
  CreateDatabase(server, "db", kLowerBody);
  REQUIRE(Add(server, "databases/db", OddMapping()).status.ok());
  REQUIRE(Add(server, "databases/db", OddMapping("0.5 foot{0} + 0.5 shin{0}")).status.ok());
  const v1::MarkerSet set = MarkerSetOf(server);
  REQUIRE(MappingNames(set) == "odd robot ");
  CHECK_THAT(set.mappings(0).text(), Contains("LAnkle = 0.5 foot1 + 0.5 shin1"));
  CHECK(IngestedOdd(server, "walk").clip().leg_length_m() == Approx(0.62).epsilon(1e-3));
}

TEST_CASE("MarkerSetService: a deleted mapping is no longer used", "[server][rpc]") {
  TestServer server;
  CreateDatabase(server, "db", kLowerBody);
  REQUIRE(Add(server, "databases/db", OddMapping()).status.ok());
  const auto walk = IngestedOdd(server, "walk");
  REQUIRE(Delete(server, "databases/db", "odd").ok());
  CHECK(MappingNames(MarkerSetOf(server)) == "robot ");
  CHECK(IngestOdd(server, "again", 1).error_code() == StatusCode::INVALID_ARGUMENT);
  CHECK(LegLength(server, walk.clip().name()) == walk.clip().leg_length_m());
  const grpc::Status again = Delete(server, "databases/db", "odd");
  CHECK(again.error_code() == StatusCode::NOT_FOUND);
  CHECK_THAT(again.error_message(), Contains("'odd'"));
  // Also one that the set came with.
  CHECK(Delete(server, "databases/db", "robot").ok());
  server.Restart();
  CHECK(MarkerSetOf(server).mappings().empty());
  CHECK(Add(server, "databases/db", OddMapping()).status.ok());
}

TEST_CASE("MarkerSetService: stored clips change only with ReprocessDatabase", "[server][rpc]") {
  TestServer server;
  CreateDatabase(server, "db", kLowerBody);
  REQUIRE(Add(server, "databases/db", OddMapping()).status.ok());
  const auto walk = IngestedOdd(server, "walk");
  server.Wait(walk.operation().name());
  REQUIRE(Add(server, "databases/db", OddMapping("0.5 foot{0} + 0.5 shin{0}")).status.ok());
  const auto later = IngestedOdd(server, "later", 1);
  server.Wait(later.operation().name());
  CHECK(later.clip().leg_length_m() == Approx(0.62).epsilon(1e-3));
  CHECK(LegLength(server, walk.clip().name()) == Approx(0.82).epsilon(1e-3));
  server.Restart();
  CHECK(LegLength(server, walk.clip().name()) == Approx(0.82).epsilon(1e-3));

  v1::ReprocessDatabaseRequest request;
  request.set_name("databases/db");
  const auto stub = server.NewStub<v1::DatabaseService>();
  const auto asked = Ask(*stub, &v1::DatabaseService::Stub::ReprocessDatabase, request);
  REQUIRE(asked.status.ok());
  const auto done = server.Wait(asked.response.operation().name());
  CHECK(done.state() == v1::OPERATION_STATE_SUCCEEDED);
  CHECK_THAT(done.stage(), Contains("clips derived again: 2, changed: 1"));
  CHECK(LegLength(server, walk.clip().name()) == Approx(0.62).epsilon(1e-3));
  CHECK(LegLength(server, later.clip().name()) == Approx(0.62).epsilon(1e-3));
}

TEST_CASE("MarkerSetService: a `source` database has a set from its first clip on",
          "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  CHECK(Get(server, "databases/db").status.error_code() == StatusCode::FAILED_PRECONDITION);
  CHECK(Add(server, "databases/db", OddMapping()).status.error_code() ==
        StatusCode::FAILED_PRECONDITION);
  CHECK(Delete(server, "databases/db", "odd").error_code() == StatusCode::FAILED_PRECONDITION);
  server.IngestFigure("db", "walk", "walk", {});
  const v1::MarkerSet set = MarkerSetOf(server);
  CHECK(set.marker_names_size() == 10);
  CHECK(set.mappings().empty());
  CHECK(Normalized(WholeFile(set)) == WholeFile(set));
}

TEST_CASE("MarkerSetService: the error names the invalid field, and nothing changes",
          "[server][rpc]") {
  TestServer server;
  CreateDatabase(server, "db", kLowerBody);
  const std::string before = MarkerSetOf(server).SerializeAsString();
  const auto refused = [&](const std::string& file, const std::string& text) {
    const auto answer = Add(server, "databases/db", file);
    INFO(answer.status.error_message());
    CHECK(answer.status.error_code() == StatusCode::INVALID_ARGUMENT);
    CHECK(ViolatedFields(answer.status) == "mapping_file");
    CHECK_THAT(answer.status.error_message(), Contains(text));
  };
  refused("", "motiondb-marker-set 1");
  refused("nonsense\n", "mapping_file:1");
  refused("motiondb-marker-set 1\nextend standard34\n", "extend lower_body");
  refused("motiondb-marker-set 1\nname lower_body\n", "expected only mappings");
  refused("motiondb-marker-set 1\nmapping m\nNose = a\n", "mapping_file:3");
  refused(OddMapping() + "mapping half\nLHip = a\n", "a rule without an offset for marker 'RHip'");
  refused(OddMapping() + "# \x1b[2J\n", "mapping_file");
  for (const char* database : {"", "db"}) {
    CHECK(ViolatedFields(Add(server, database, OddMapping()).status) == "database");
    CHECK(ViolatedFields(Delete(server, database, "robot")) == "database");
  }
  CHECK(ViolatedFields(Get(server, "db").status) == "database");
  CHECK(Get(server, "databases/none").status.error_code() == StatusCode::NOT_FOUND);
  CHECK(Add(server, "databases/none", OddMapping()).status.error_code() == StatusCode::NOT_FOUND);
  CHECK(Delete(server, "databases/none", "odd").error_code() == StatusCode::NOT_FOUND);
  CHECK(MarkerSetOf(server).SerializeAsString() == before);
}

TEST_CASE("MarkerSetService: the number of mappings is limited", "[server][rpc]") {
  TestServer server;
  CreateDatabase(server, "db", kLowerBody);
  const auto mappings = [](std::size_t count) {
    std::string text = "motiondb-marker-set 1\n";
    for (std::size_t i = 0; i < count; ++i) {
      text += fmt::format(
          "mapping m{}\nLHip = a\nRHip = b\nLKnee = c\nRKnee = d\nLAnkle = e\nRAnkle = f\n", i);
    }
    return text;
  };
  const auto refused = Add(server, "databases/db", mappings(core::kMaxMappings));
  CHECK(refused.status.error_code() == StatusCode::RESOURCE_EXHAUSTED);
  CHECK(ReasonOf(refused.status) == "QUOTA_EXCEEDED");
  CHECK(MappingNames(MarkerSetOf(server)) == "robot ");
  REQUIRE(Add(server, "databases/db", mappings(core::kMaxMappings - 1)).status.ok());
  CHECK(MarkerSetOf(server).mappings_size() == static_cast<int>(core::kMaxMappings));
  server.Restart();
  CHECK(MarkerSetOf(server).mappings_size() == static_cast<int>(core::kMaxMappings));
}

}  // namespace
}  // namespace motiondb::tests::marker_set_service_test
