// Limits on memory and work of one call.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/edit.grpc.pb.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "tests/server/rpc/limited_server.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::memory_of_calls_test {
namespace {

using grpc::StatusCode;

bool HasText(const grpc::Status& status, const std::string& text) {
  return status.error_message().find(text) != std::string::npos;
}

// Six frames of the markers of the stick figure.
v1::Observation SixFrames(double frame_rate_hz) {
  v1::Observation observation = WalkObservation();
  std::string& file = *observation.mutable_file()->mutable_data();
  file = WriteBvh({.frame_count = 6});
  const std::size_t at = file.find("Frame Time:");
  file.replace(at, file.find('\n', at) - at, "Frame Time: " + std::to_string(1 / frame_rate_hz));
  return observation;
}

// A BVH file with 2 bytes for each frame: one degree of freedom.
std::string SmallFile(int frames) {
  std::string text =
      "HIERARCHY\nROOT Hips\n{\nOFFSET 0 90 0\nCHANNELS 1 Yrotation\n"
      "JOINT LeftUpLeg\n{\nOFFSET 10 0 0\nCHANNELS 0\nJOINT LeftLeg\n{\nOFFSET 0 -45 0\n"
      "CHANNELS 0\nJOINT LeftFoot\n{\nOFFSET 0 -45 0\nCHANNELS 0\n}\n}\n}\n"
      "JOINT RightUpLeg\n{\nOFFSET -10 0 0\nCHANNELS 0\nJOINT RightLeg\n{\nOFFSET 0 -45 0\n"
      "CHANNELS 0\nJOINT RightFoot\n{\nOFFSET 0 -45 0\nCHANNELS 0\nEnd Site\n{\nOFFSET 0 0 "
      "15\n}\n}\n}\n}\n}\n"
      "MOTION\nFrames: " +
      std::to_string(frames) + "\nFrame Time: 0.0166667\n";
  for (int f = 0; f < frames; ++f) text += "0\n";
  return text;
}

grpc::Status Recognize(TestServer& server, const v1::Observation& observation) {
  v1::RecognizeRequest request;
  request.set_database("databases/db");
  *request.mutable_observation() = observation;
  const auto queries = server.NewStub<v1::QueryService>();
  return Ask(*queries, &v1::QueryService::Stub::Recognize, request).status;
}

TEST_CASE("Memory: six frames cannot become hours of motion", "[server][limits]") {
  TestServer server;
  server.CreateTrained("db");
  const grpc::Status slow = Recognize(server, SixFrames(0.00144));
  INFO(slow.error_message());
  CHECK(slow.error_code() == StatusCode::INVALID_ARGUMENT);
  CHECK(slow.error_details().find("observation.file") != std::string::npos);
  CHECK(HasText(slow, "Frame Time: 694"));
  CHECK(Recognize(server, SixFrames(0.00125)).error_code() == StatusCode::INVALID_ARGUMENT);
  CHECK(Recognize(server, SixFrames(2)).ok());

  v1::IngestClipHeader header;
  header.set_parent("databases/db");
  header.set_file_name("slow.bvh");
  const grpc::Status ingested = server.Ingest(header, SixFrames(0.00125).file().data());
  INFO(ingested.error_message());
  CHECK(ingested.error_code() == StatusCode::INVALID_ARGUMENT);
  CHECK(HasText(ingested, "Frame Time: 800"));
}

TEST_CASE("Memory: the limit of a call depends on its size", "[server][limits]") {
  TestServer server;
  server.CreateDatabase("db");
  const auto ingest = [&](const std::string& name, int frames) {
    v1::IngestClipHeader header;
    header.set_parent("databases/db");
    header.set_file_name(name);
    return server.Ingest(header, SmallFile(frames));
  };
  const grpc::Status first = ingest("short.bvh", 600);
  INFO(first.error_message());
  REQUIRE(first.ok());
  // 450 kB that would need about 150 MB.
  const grpc::Status refused = ingest("long.bvh", 225'000);
  INFO(refused.error_message());
  CHECK(refused.error_code() == StatusCode::RESOURCE_EXHAUSTED);
  CHECK(HasText(refused, "MiB of memory"));
}

TEST_CASE("Memory: a call releases its memory, however it ends", "[server][limits]") {
  // Each call below reserves at least a tenth of the budget.
  TestServer server(With({.message_memory_bytes = 32 << 20}));
  server.CreateTrained("db");
  v1::Observation walk = WalkObservation();
  walk.mutable_file()->set_data(WriteBvh({.frame_count = 1500}));
  v1::Observation broken = walk;
  broken.mutable_file()->mutable_data()->append("no number");
  for (int i = 0; i < 30; ++i) {
    CHECK(Recognize(server, broken).error_code() == StatusCode::INVALID_ARGUMENT);
    const grpc::Status status = Recognize(server, walk);
    INFO(status.error_message());
    CHECK(status.ok());
  }
}

TEST_CASE("Work: the total work of a prediction series is bounded", "[server][limits]") {
  TestServer server;
  server.CreateTrained("db");
  v1::PredictSeriesRequest request;
  request.mutable_prediction()->set_database("databases/db");
  v1::Observation& observation = *request.mutable_prediction()->mutable_observation();
  observation = WalkObservation();
  observation.mutable_file()->set_data(WriteBvh({.frame_count = 2000}));
  for (int h = 0; h < 1000; ++h) {
    request.mutable_prediction()->add_horizon_seconds(0.001 * h);
  }
  request.set_every_seconds(1.0 / 60);
  const auto queries = server.NewStub<v1::QueryService>();
  grpc::ClientContext context;
  const auto series = queries->PredictSeries(&context, request);
  v1::PredictSeriesResponse prediction;
  CHECK_FALSE(series->Read(&prediction));
  const grpc::Status refused = series->Finish();
  INFO(refused.error_message());
  CHECK(refused.error_code() == StatusCode::INVALID_ARGUMENT);
  CHECK(HasText(refused, "every_seconds"));
}

TEST_CASE("Memory: a stored change is answered even if its response is too large",
          "[server][limits]") {
  TestServer server;
  server.CreateDatabase("db");
  server.IngestFigure("db", "walk", "walking", {.frame_count = 90});
  v1::BatchEditRequest batch;
  batch.set_parent("databases/db");
  for (int i = 0; i < 600; ++i) {
    v1::CreateSegmentRequest& change = *batch.add_changes()->mutable_create_segment();
    change.set_parent("databases/db/clips/walk");
    change.mutable_segment()->set_track("t" + std::to_string(i % 10));
    change.mutable_segment()->set_label("l");
    change.mutable_segment()->set_start_seconds(0.02 * (i / 10));
    change.mutable_segment()->set_end_seconds(0.02 * (i / 10 + 1));
  }
  using Edits = v1::EditService::Stub;
  const auto edited = Ask(*server.NewStub<v1::EditService>(), &Edits::BatchEdit, batch);
  INFO(edited.status.error_message());
  REQUIRE(edited.status.ok());

  server.Stop();
  server.options().calls.message_memory_bytes = 256 << 10;
  server.Start();
  const auto edits = server.NewStub<v1::EditService>();
  v1::ListEditsRequest history;
  history.set_parent("databases/db");
  // Nothing depends on this response.
  CHECK(Ask(*edits, &Edits::ListEdits, history).status.error_code() ==
        StatusCode::RESOURCE_EXHAUSTED);
  v1::UndoEditRequest undo;
  undo.set_name(edited.response.edit().name());
  const auto undone = Ask(*edits, &Edits::UndoEdit, undo);
  INFO(undone.status.error_message());
  CHECK(undone.status.ok());
  CHECK(undone.response.edit().objects_size() == 600);
}

}  // namespace
}  // namespace motiondb::tests::memory_of_calls_test
