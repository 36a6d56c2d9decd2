// A server with a trained database, shared by tests, and requests for it.
#pragma once

#include <string>

#include "motiondb/v1/observation.pb.h"
#include "tests/support/test_server.h"

namespace motiondb::tests {

// The server of all tests that only query. Databases: `db` with a walk of 2.6 m in 2 s, a squat and
// a wave; `empty` without a model.
inline TestServer& TrainedServer() {
  static TestServer server;
  static const bool kTrained = [] {
    server.CreateTrained("db");
    server.CreateDatabase("empty");
    return true;
  }();
  (void)kTrained;
  return server;
}

// Returns a request of QueryService with a database and an observed walk.
template <typename Request>
Request RequestFor(const std::string& database) {
  Request request;
  request.set_database("databases/" + database);
  *request.mutable_observation() = WalkObservation();
  return request;
}

}  // namespace motiondb::tests
