// The server of the tests of Plan, and their basic request.
#pragma once

#include "motiondb/v1/plan.pb.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "tests/server/rpc/trained_server.h"
#include "tests/support/test_server.h"

namespace motiondb::tests {

inline TestServer& PlanServer() { return TrainedServer(); }

// Plans from the walk to a goal straight ahead.
inline v1::PlanRequest WalkAhead(double metres = 1) {
  v1::PlanRequest request;
  request.set_database("databases/db");
  request.mutable_clip_start()->set_clip("databases/db/clips/walk");
  request.mutable_clip_start()->set_seconds(0.2);
  request.mutable_goal()->set_x_m(metres);
  return request;
}

inline Answer<v1::PlanResponse> AskPlan(TestServer& server, const v1::PlanRequest& request) {
  const auto stub = server.NewStub<v1::QueryService>();
  return Ask(*stub, &v1::QueryService::Stub::Plan, request);
}

}  // namespace motiondb::tests
