// A stream ends at its next message after its token became invalid.
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <thread>

#include "motiondb/v1/access.grpc.pb.h"
#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/observe.grpc.pb.h"
#include "motiondb/v1/operation.grpc.pb.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::stream_test {
namespace {

using Access = v1::AccessService::Stub;
using grpc::StatusCode;

struct ServerWithTokens {
  ServerWithTokens() {
    server.CreateTrained("db");
    admin = Make(v1::ROLE_ADMIN);
    user = Make(v1::ROLE_INGESTER);
    server.options().security.authentication = server::Authentication::kToken;
    server.Restart();
    context.AddMetadata("authorization", "Bearer " + user.secret());
  }
  v1::CreateTokenResponse Make(v1::Role role) {
    v1::CreateTokenRequest request;
    request.mutable_token()->set_role(role);
    return Ask(*server.NewStub<v1::AccessService>(), &Access::CreateToken, request).response;
  }
  void RevokeUser() {
    v1::RevokeTokenRequest request;
    request.set_name(user.token().name());
    REQUIRE(Ask(*server.NewStub<v1::AccessService>(), &Access::RevokeToken, request, admin.secret())
                .status.ok());
  }

  TestServer server;
  v1::CreateTokenResponse admin;
  v1::CreateTokenResponse user;
  grpc::ClientContext context;
};

TEST_CASE("Streams: an observation ends when its token is revoked", "[security][rpc]") {
  ServerWithTokens guarded;
  const auto stub = guarded.server.NewStub<v1::ObserveService>();
  v1::RepresentRequest represent;
  represent.set_database("databases/db");
  *represent.mutable_observation() = WalkObservation();
  const auto walk =
      Ask(*stub, &v1::ObserveService::Stub::Represent, represent, guarded.user.secret());
  REQUIRE(walk.status.ok());

  const auto stream = stub->Observe(&guarded.context);
  v1::ObserveRequest request;
  request.mutable_start()->set_database("databases/db");
  const auto& markers = walk.response.markers();
  *request.mutable_start()->mutable_marker_names() = markers.marker_names();
  request.mutable_start()->set_frame_rate_hz(markers.frame_rate_hz());
  REQUIRE(stream->Write(request));
  const int frame_bytes = 12 * markers.marker_names_size();
  v1::ObserveResponse response;
  for (int frame = 0; frame < 2; ++frame) {
    request.mutable_frames()->set_first_frame(frame);
    request.mutable_frames()->set_frame_count(1);
    request.mutable_frames()->set_positions(
        markers.positions().substr(frame * frame_bytes, frame_bytes));
    if (frame == 1) guarded.RevokeUser();
    REQUIRE(stream->Write(request));
    CHECK(stream->Read(&response) == (frame == 0));
  }
  const grpc::Status status = stream->Finish();
  CHECK(status.error_code() == StatusCode::UNAUTHENTICATED);
  CHECK(status.error_message() == guarded.user.token().name() + " was revoked");
}

TEST_CASE("Streams: an ingest ends when its token is revoked, and stores nothing",
          "[security][rpc]") {
  ServerWithTokens guarded;
  const auto stub = guarded.server.NewStub<v1::ClipService>();
  v1::IngestClipResponse response;
  const auto writer = stub->IngestClip(&guarded.context, &response);
  v1::IngestClipRequest message;
  message.mutable_header()->set_parent("databases/db");
  message.mutable_header()->set_file_name("new.bvh");
  REQUIRE(writer->Write(message));
  message.set_file_block(WriteBvh({}).substr(0, 100));
  REQUIRE(writer->Write(message));
  guarded.RevokeUser();
  while (writer->Write(message)) {
  }
  CHECK(writer->Finish().error_code() == StatusCode::UNAUTHENTICATED);
  v1::ListClipsRequest list;
  list.set_parent("databases/db");
  const auto listed = Ask(*stub, &v1::ClipService::Stub::ListClips, list, guarded.admin.secret());
  CHECK(listed.response.clips_size() == 3);
}

TEST_CASE("Streams: a wait for an operation returns no result after its token is revoked",
          "[security][rpc]") {
  ServerWithTokens guarded;
  guarded.server.gate().Close();
  v1::IngestClipResponse ingested;
  const auto clips = guarded.server.NewStub<v1::ClipService>();
  const auto writer = clips->IngestClip(&guarded.context, &ingested);
  v1::IngestClipRequest message;
  message.mutable_header()->set_parent("databases/db");
  message.mutable_header()->set_file_name("new.bvh");
  REQUIRE(writer->Write(message));
  message.set_file_block(WriteBvh({}));
  REQUIRE(writer->Write(message));
  writer->WritesDone();
  REQUIRE(writer->Finish().ok());
  const auto operations = guarded.server.NewStub<v1::OperationService>();
  v1::WaitOperationRequest request;
  request.set_name(ingested.operation().name());
  grpc::Status status;
  std::thread waiting([&] {
    status =
        Ask(*operations, &v1::OperationService::Stub::WaitOperation, request, guarded.user.secret())
            .status;
  });
  guarded.server.gate().AwaitArrival();
  while (guarded.server.server().monitor().calls().open() == 0) std::this_thread::yield();
  guarded.RevokeUser();
  guarded.server.gate().Open();
  waiting.join();
  CHECK(status.error_code() == StatusCode::UNAUTHENTICATED);
}

}  // namespace
}  // namespace motiondb::tests::stream_test
