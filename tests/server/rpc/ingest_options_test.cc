// Options of IngestClip: validate_only, replace, force; and the check of the body size in queries.
#include <Eigen/Core>
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/observe.grpc.pb.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "tests/server/rpc/status_of.h"
#include "tests/server/rpc/trained_server.h"
#include "tests/support/packed_floats.h"
#include "tests/support/stick_figure.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::ingest_options_test {
namespace {

using Catch::Contains;
using grpc::StatusCode;

// Hip to knee to ankle of the stick figure, in centimetres.
constexpr double kLeg_cm = 82;

v1::IngestClipHeader Header(const std::string& file_name) {
  v1::IngestClipHeader header;
  header.set_parent("databases/db");
  header.set_file_name(file_name);
  return header;
}

v1::IngestClipHeader HeaderWithUnit(double metres_per_unit, bool force = false) {
  v1::IngestClipHeader header = Header("walk.bvh");
  header.mutable_conventions()->set_metres_per_unit(metres_per_unit);
  header.mutable_conventions()->set_force(force);
  return header;
}

v1::IngestClipResponse Ingested(TestServer& server, const v1::IngestClipHeader& header,
                                const std::string& bytes = WriteBvh({})) {
  v1::IngestClipResponse response;
  const grpc::Status status = server.Ingest(header, bytes, &response);
  INFO(status.error_message());
  REQUIRE(status.ok());
  return response;
}

void CheckRefused(const grpc::Status& status, const std::string& field, const std::string& text) {
  CHECK(status.error_code() == StatusCode::INVALID_ARGUMENT);
  CHECK(ViolatedFields(status) == field);
  CHECK_THAT(status.error_message(), Contains(text) && Contains("force"));
}

v1::Clip StoredClip(TestServer& server, const std::string& name) {
  v1::GetClipRequest request;
  request.set_name(name);
  const auto stub = server.NewStub<v1::ClipService>();
  const auto answer = Ask(*stub, &v1::ClipService::Stub::GetClip, request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  return answer.response.clip();
}

v1::Database StoredDatabase(TestServer& server) {
  v1::GetDatabaseRequest request;
  request.set_name("databases/db");
  const auto stub = server.NewStub<v1::DatabaseService>();
  const auto answer = Ask(*stub, &v1::DatabaseService::Stub::GetDatabase, request);
  REQUIRE(answer.status.ok());
  return answer.response.database();
}

// Returns the distance of the figure's hips (m) in a motion of joint angles on a skeleton.
double HipWidth(TestServer& server, const std::string& skeleton) {
  constexpr int kFrames = 4;
  constexpr int kDofs = 33;
  v1::RepresentRequest request;
  request.set_database("databases/db");
  v1::JointObservation& joints = *request.mutable_observation()->mutable_joints();
  joints.set_skeleton(skeleton);
  joints.set_frame_rate_hz(60);
  joints.set_frame_count(kFrames);
  joints.set_angles(Pack(std::vector<float>(kFrames * kDofs, 0.0F)));
  const auto stub = server.NewStub<v1::ObserveService>();
  const auto answer = Ask(*stub, &v1::ObserveService::Stub::Represent, request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  const std::vector<float> positions = Unpack(answer.response.markers().positions());
  const auto& names = answer.response.markers().marker_names();
  const auto at = [&](const char* name) {
    const auto marker = std::ranges::find(names, name) - names.begin();
    REQUIRE(marker < names.size());
    return Eigen::Vector3f(positions.data() + 3 * marker);
  };
  return (at("LeftUpLeg") - at("RightUpLeg")).norm();
}

TEST_CASE("IngestClip: validate_only checks a clip and stores nothing", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  const std::string walk = WriteBvh({});
  v1::IngestClipHeader checking = Header("walk.bvh");
  checking.set_validate_only(true);

  const auto checked = Ingested(server, checking, walk);
  CHECK(checked.clip().name() == "databases/db/clips/walk");
  CHECK(checked.clip().frame_count() == 60);
  CHECK(checked.clip().leg_length_m() == Approx(kLeg_cm / 100));
  CHECK(!checked.has_operation());
  CHECK(StoredDatabase(server).clip_count() == 0);
  CHECK(StoredDatabase(server).frame_count() == 0);
  CHECK(StoredDatabase(server).marker_names().empty());  // `source`: of the first clip
  CHECK(StatusOf(server).databases(0).byte_count() == 0);
  CHECK(server.Ingest(checking, walk.substr(0, walk.size() - 300)).error_code() ==
        StatusCode::INVALID_ARGUMENT);

  const auto stored = Ingested(server, Header("walk.bvh"), walk);
  CHECK(server.Wait(stored.operation().name()).state() == v1::OPERATION_STATE_SUCCEEDED);
  const std::string before = StoredDatabase(server).SerializeAsString();
  SECTION("ALREADY_EXISTS for a stored motion and for a stored id") {
    const auto same_motion = server.Ingest(checking, walk);
    CHECK(same_motion.error_code() == StatusCode::ALREADY_EXISTS);
    CHECK_THAT(same_motion.error_message(), Contains("'walk'"));
    checking.set_clip_id("walk");
    const auto same_id = server.Ingest(checking, WriteBvh({.phase = 1}));
    CHECK(same_id.error_code() == StatusCode::ALREADY_EXISTS);
    CHECK_THAT(same_id.error_message(), Contains("'walk'"));
  }
  SECTION("OK for another motion") {
    CHECK(Ingested(server, checking, WriteBvh({.phase = 1})).clip().frame_count() == 60);
  }
  SECTION("with replace, the stored clip stays") {
    checking.set_replace(true);
    checking.mutable_conventions()->set_metres_per_unit(0.015);
    CHECK(Ingested(server, checking, walk).clip().leg_length_m() == Approx(0.015 * kLeg_cm));
    CHECK(StoredClip(server, stored.clip().name()).SerializeAsString() ==
          stored.clip().SerializeAsString());
  }
  CHECK(StoredDatabase(server).SerializeAsString() == before);
  server.Restart();
  CHECK(StoredDatabase(server).SerializeAsString() == before);
}

TEST_CASE("IngestClip: replace corrects the unit of a clip", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  v1::IngestClipHeader header = HeaderWithUnit(0.02, true);
  header.set_label("walking");
  header.set_subject("s1");
  const auto wrong = Ingested(server, header);
  CHECK(wrong.clip().leg_length_m() == Approx(0.02 * kLeg_cm));
  server.Wait(wrong.operation().name());
  const auto other = server.IngestFigure("db", "other", "other", {.phase = 1});
  server.Wait(other.operation().name());
  const int version = server.Describe("db").model_version();

  v1::IngestClipHeader corrected = HeaderWithUnit(0.01);
  corrected.set_file_name("again.bvh");
  CHECK(server.Ingest(corrected, WriteBvh({})).error_code() == StatusCode::ALREADY_EXISTS);
  corrected.set_replace(true);
  const auto right = Ingested(server, corrected);
  CHECK(right.clip().name() == wrong.clip().name());
  CHECK(right.clip().label() == "walking");
  CHECK(right.clip().subject() == "s1");
  CHECK(right.clip().file_name() == "again.bvh");
  CHECK(right.clip().leg_length_m() == Approx(0.01 * kLeg_cm));
  CHECK(StoredClip(server, wrong.clip().name()).SerializeAsString() ==
        right.clip().SerializeAsString());
  CHECK(StoredClip(server, other.clip().name()).SerializeAsString() ==
        other.clip().SerializeAsString());
  CHECK(StoredDatabase(server).clip_count() == 2);
  CHECK(StoredDatabase(server).frame_count() == 120);
  CHECK(server.Wait(right.operation().name()).state() == v1::OPERATION_STATE_SUCCEEDED);
  CHECK(server.Describe("db").clip_count() == 2);
  CHECK(server.Describe("db").frame_count() == 120);
  CHECK(server.Describe("db").model_version() > version);

  // The amounts that are counted are those in the store.
  const auto counted = StatusOf(server).databases(0);
  server.Restart();
  CHECK(StatusOf(server).databases(0).byte_count() == counted.byte_count());
  CHECK(StatusOf(server).databases(0).clip_count() == counted.clip_count());
  CHECK(StoredDatabase(server).frame_count() == 120);
}

TEST_CASE("IngestClip: after a replacement, joint angles refer to the new skeleton",
          "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  const auto wrong = Ingested(server, HeaderWithUnit(0.02, true));
  server.Wait(wrong.operation().name());
  CHECK(HipWidth(server, wrong.clip().skeleton()) == Approx(0.36));
  v1::IngestClipHeader corrected = HeaderWithUnit(0.01);
  corrected.set_replace(true);
  const auto right = Ingested(server, corrected);
  server.Wait(right.operation().name());
  CHECK(HipWidth(server, right.clip().skeleton()) == Approx(0.18));
}

TEST_CASE("IngestClip: replace by id, with new labels, and without a stored clip",
          "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  v1::IngestClipHeader header = Header("walk.bvh");
  header.set_replace(true);
  header.set_label("walking");
  header.set_subject("s1");
  CHECK(Ingested(server, header).clip().name() == "databases/db/clips/walk");
  CHECK(StoredDatabase(server).clip_count() == 1);

  SECTION("another motion under the id") {
    header.set_clip_id("walk");
    header.set_label("squatting");
    header.clear_subject();
    const std::string squat = WriteBvh({.act = Act::kSquat, .frame_count = 90});
    const auto replaced = Ingested(server, header, squat);
    CHECK(replaced.clip().name() == "databases/db/clips/walk");
    CHECK(replaced.clip().label() == "squatting");
    CHECK(replaced.clip().subject() == "s1");
    CHECK(StoredDatabase(server).clip_count() == 1);
    CHECK(StoredDatabase(server).frame_count() == 90);
    // The former motion is no longer stored.
    CHECK(server.Ingest(Header("walk.bvh"), squat).error_code() == StatusCode::ALREADY_EXISTS);
    CHECK(Ingested(server, Header("walk.bvh")).clip().name() == "databases/db/clips/walk-2");
  }
  SECTION("another motion without an id is added") {
    const auto added = Ingested(server, header, WriteBvh({.phase = 1}));
    CHECK(added.clip().name() == "databases/db/clips/walk-2");
    CHECK(StoredDatabase(server).clip_count() == 2);
  }
}

TEST_CASE("IngestClip: replace does not take a motion for a clip with another id",
          "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  v1::IngestClipHeader header = Header("walk.bvh");
  header.set_clip_id("run");
  Ingested(server, header);
  header.set_clip_id("walk");
  header.set_replace(true);
  CHECK(server.Ingest(header, WriteBvh({})).error_code() == StatusCode::ALREADY_EXISTS);
  header.set_clip_id("run");
  CHECK(Ingested(server, header).clip().name() == "databases/db/clips/run");
}

TEST_CASE("IngestClip: a body that no person has needs force", "[server][rpc]") {
  TestServer server;
  server.CreateDatabase("db");
  const std::string walk = WriteBvh({});
  SECTION("a unit of 1 m: legs of 82 m") {
    CheckRefused(server.Ingest(HeaderWithUnit(1), walk), "file_block",
                 "walk.bvh: the legs would be 82 m long with 1 m per unit; expected 0.3 to 1.5 m "
                 "for a person; the unit is probably cm: set metres_per_unit 0.01");
    CHECK(StoredDatabase(server).clip_count() == 0);
    CHECK(Ingested(server, HeaderWithUnit(1, true)).clip().leg_length_m() == Approx(kLeg_cm));
  }
  SECTION("a given leg length in centimetres") {
    v1::IngestClipHeader header = Header("walk.bvh");
    header.mutable_conventions()->set_leg_length_m(85);
    CheckRefused(server.Ingest(header, walk), "header.conventions.leg_length_m",
                 "expected 0.3 to 1.5 m for a person, got 85; 85 cm are 0.85 m");
    CHECK(StoredDatabase(server).clip_count() == 0);
    header.mutable_conventions()->set_force(true);
    CHECK(Ingested(server, header).clip().leg_length_m() == 85);
  }
  SECTION("validate_only refuses it, too") {
    v1::IngestClipHeader header = HeaderWithUnit(1);
    header.set_validate_only(true);
    CheckRefused(server.Ingest(header, walk), "file_block", "set metres_per_unit 0.01");
  }
}

TEST_CASE("Recognize: a file with a body that no person has needs force", "[server][rpc]") {
  const auto stub = TrainedServer().NewStub<v1::QueryService>();
  const auto recognize = [&](const auto& change) {
    auto request = RequestFor<v1::RecognizeRequest>("db");
    change(*request.mutable_observation()->mutable_file()->mutable_conventions());
    return Ask(*stub, &v1::QueryService::Stub::Recognize, request).status;
  };
  CHECK(recognize([](auto& given) { given.set_metres_per_unit(0.01); }).ok());
  CheckRefused(recognize([](auto& given) { given.set_metres_per_unit(1); }), "observation.file",
               "the legs would be 82 m long");
  CheckRefused(recognize([](auto& given) { given.set_leg_length_m(85); }),
               "observation.file.conventions.leg_length_m", "85 cm are 0.85 m");
  const grpc::Status forced = recognize([](auto& given) {
    given.set_metres_per_unit(1);
    given.set_force(true);
  });
  INFO(forced.error_message());
  CHECK(forced.ok());
}

TEST_CASE("Represent: a file with a body that no person has needs force", "[server][rpc]") {
  const auto stub = TrainedServer().NewStub<v1::ObserveService>();
  auto request = RequestFor<v1::RepresentRequest>("db");
  auto& given = *request.mutable_observation()->mutable_file()->mutable_conventions();
  given.set_metres_per_unit(1);
  CheckRefused(Ask(*stub, &v1::ObserveService::Stub::Represent, request).status, "observation.file",
               "the legs would be 82 m long");
  given.set_force(true);
  CHECK(Ask(*stub, &v1::ObserveService::Stub::Represent, request).status.ok());
}

}  // namespace
}  // namespace motiondb::tests::ingest_options_test
