// A client of Observe that sends a walk.
#pragma once

#include <catch2/catch.hpp>
#include <memory>
#include <string>

#include "motiondb/v1/observe.grpc.pb.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::observing {

// A walk as the frames of the database's markers.
inline v1::MarkerObservation WalkingMarkers(TestServer& server, const std::string& token = "") {
  const auto stub = server.NewStub<v1::ObserveService>();
  v1::RepresentRequest request;
  request.set_database("databases/db");
  *request.mutable_observation() = WalkObservation();
  const auto answer = Ask(*stub, &v1::ObserveService::Stub::Represent, request, token);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  return answer.response.markers();
}

inline v1::ObserveRequest Start(const v1::MarkerObservation& motion) {
  v1::ObserveRequest request;
  v1::ObserveStart& start = *request.mutable_start();
  start.set_database("databases/db");
  *start.mutable_marker_names() = motion.marker_names();
  start.set_frame_rate_hz(motion.frame_rate_hz());
  return request;
}

// Frames [first, first + count) of a motion, numbered from `number`.
inline v1::ObserveRequest Frames(const v1::MarkerObservation& motion, int first, int count,
                                 std::int64_t number) {
  const std::size_t width = motion.positions().size() / motion.frame_count();
  v1::ObserveRequest request;
  v1::ObservedFrames& frames = *request.mutable_frames();
  frames.set_first_frame(number);
  frames.set_frame_count(count);
  frames.set_positions(motion.positions().substr(first * width, count * width));
  return request;
}

// Large responses soon fill the flow-control window.
inline v1::ObserveRequest StartOfLargeAnswers(const v1::MarkerObservation& motion) {
  v1::ObserveRequest start = Start(motion);
  for (int h = 1; h <= 100; ++h) start.mutable_start()->add_horizon_seconds(0.01 * h);
  return start;
}

// An open stream: sends one message and reads one response at a time.
class Stream {
 public:
  explicit Stream(TestServer& server, const std::string& token = "")
      : Stream(server.channel(), token) {}
  explicit Stream(const std::shared_ptr<grpc::Channel>& channel, const std::string& token = "")
      : stub_(v1::ObserveService::NewStub(channel)) {
    if (!token.empty()) context_.AddMetadata("authorization", "Bearer " + token);
    call_ = stub_->Observe(&context_);
  }

  bool Send(const v1::ObserveRequest& request) { return call_->Write(request); }
  bool Receive(v1::ObserveResponse& response) { return call_->Read(&response); }
  v1::ObserveResponse Ask(const v1::ObserveRequest& request) {
    v1::ObserveResponse response;
    REQUIRE(Send(request));
    if (!Receive(response)) FAIL("the stream ended: " << Finish().error_message());
    return response;
  }
  void Close() { call_->WritesDone(); }
  grpc::Status Finish() { return call_->Finish(); }
  void Cancel() { context_.TryCancel(); }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<v1::ObserveService::Stub> stub_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::ObserveRequest, v1::ObserveResponse>> call_;
};

}  // namespace motiondb::tests::observing
