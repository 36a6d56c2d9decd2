// Answers of a fake server to `motiondb ingest`.
#pragma once

#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/model.pb.h>
#include <motiondb/v1/operation.pb.h>

#include <string>
#include <vector>

#include "tests/client/fake_server.h"

namespace motiondb::tests {

// Returns a clip of 100 frames, whose model `operation` builds.
inline v1::IngestClipResponse StoredClip(const std::string& clip, const std::string& operation) {
  v1::IngestClipResponse response;
  response.mutable_clip()->set_name("databases/walks/clips/" + clip);
  response.mutable_clip()->set_frame_count(100);
  response.mutable_clip()->set_source_report("unit: metre, as given");
  response.mutable_operation()->set_name(operation);
  return response;
}

// Serves a database that accepts clips and builds model 3.
inline void ServeDatabase(FakeServer& server) {
  server.Answer("GetDatabase", v1::GetDatabaseResponse());
  v1::WaitOperationResponse running, done;
  running.mutable_operation()->set_progress(0.4);
  running.mutable_operation()->set_stage("tree, layer 7");
  done.mutable_operation()->set_state(v1::OPERATION_STATE_SUCCEEDED);
  done.mutable_operation()->mutable_rebuild()->set_model("databases/walks/models/3");
  server.Answer("WaitOperation", running);
  server.Answer("WaitOperation", done);
  v1::GetModelResponse model;
  model.mutable_model()->set_version(3);
  model.mutable_model()->set_clip_count(19);
  model.mutable_model()->set_frame_count(6552);
  model.mutable_model()->set_build_seconds(4.2);
  server.Answer("GetModel", model);
}

// Returns the header of each ingested file.
inline std::vector<v1::IngestClipHeader> IngestHeaders(const FakeServer& server) {
  std::vector<v1::IngestClipHeader> headers;
  for (const auto& message : server.Requests<v1::IngestClipRequest>("IngestClip")) {
    if (message.has_header()) headers.push_back(message.header());
  }
  return headers;
}

}  // namespace motiondb::tests
