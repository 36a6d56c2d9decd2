#include "tests/support/test_server.h"

#include <grpc/grpc.h>
#include <grpcpp/create_channel.h>
#include <spdlog/spdlog.h>

#include <catch2/catch.hpp>

#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/error.pb.h"
#include "motiondb/v1/operation.grpc.pb.h"
#include "motiondb/v1/query.pb.h"
#include "storage/sqlite/sqlite_motion_store.h"

namespace motiondb::tests {
namespace {

server::ServerOptions QuickOptions() {
  server::ServerOptions options;
  options.engine.rebuild_delay = std::chrono::milliseconds(50);
  options.engine.extend_from = std::chrono::hours(1);  // one model per change
  options.engine.query_threads = 4;
  return options;
}

std::shared_ptr<grpc::Channel> OpenChannel(const server::Server& server,
                                           grpc::ChannelArguments arguments) {
  // A subchannel pool of its own: gRPC's global one remembers a server that has ended.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(server.address(), grpc::InsecureChannelCredentials(), arguments);
}

}  // namespace

TestServer::TestServer() : TestServer(QuickOptions()) {}

TestServer::TestServer(const server::ServerOptions& options) : options_(options) {
  // As in motiondbd, gRPC stays initialized between tests.
  static const bool kHeld = (grpc_init(), true);
  (void)kHeld;
  options_.listen = "127.0.0.1:0";
  spdlog::set_level(spdlog::level::off);
  Start();
}

TestServer::~TestServer() {
  if (server_ != nullptr) Stop();
}

void TestServer::Restart() {
  Stop();
  Start();
}

void TestServer::Stop() {
  gate_->Open();
  model_gate_->Open();
  server_.reset();
}

void TestServer::Start() {
  // Another process may take the port between gRPC's bind and listen; retry.
  for (int tries = 0; server_ == nullptr; ++tries) {
    auto store = storage::SqliteMotionStore::Open(directory_ / "store.db");
    INFO(store.status().ToString());
    REQUIRE(store.ok());
    auto gated = std::make_unique<GatedStore>(*std::move(store), gate_, model_gate_, disk_);
    auto server = server::Server::Start(std::move(gated), options_);
    INFO(server.status().ToString());
    const bool taken = absl::IsUnavailable(server.status()) && tries < 5;
    REQUIRE((server.ok() || taken));
    if (server.ok()) server_ = *std::move(server);
  }
  channel_ = NewChannel();
}

std::shared_ptr<grpc::Channel> TestServer::NewChannel() const { return OpenChannel(*server_, {}); }

std::shared_ptr<grpc::Channel> TestServer::NewSmallChannel() const {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  arguments.SetInt(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, 1 << 16);
  return OpenChannel(*server_, arguments);
}

void TestServer::CreateDatabase(const std::string& id) {
  v1::CreateDatabaseRequest request;
  request.set_database_id(id);
  request.mutable_database()->set_marker_set("source");
  request.mutable_database()->set_min_frames(4);
  const auto stub = NewStub<v1::DatabaseService>();
  const auto answer = Ask(*stub, &v1::DatabaseService::Stub::CreateDatabase, request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
}

grpc::Status TestServer::Ingest(const v1::IngestClipHeader& header, const std::string& bytes,
                                v1::IngestClipResponse* response) {
  constexpr std::size_t kBlock = 4096;
  v1::IngestClipResponse unused;
  grpc::ClientContext context;
  const auto stub = NewStub<v1::ClipService>();
  const auto writer = stub->IngestClip(&context, response == nullptr ? &unused : response);
  v1::IngestClipRequest message;
  *message.mutable_header() = header;
  bool going = writer->Write(message);
  for (std::size_t begin = 0; going && begin < bytes.size(); begin += kBlock) {
    message.set_file_block(bytes.substr(begin, kBlock));
    going = writer->Write(message);
  }
  writer->WritesDone();
  return writer->Finish();
}

v1::IngestClipResponse TestServer::IngestFigure(const std::string& database,
                                                const std::string& name, const std::string& label,
                                                const StickFigure& figure) {
  v1::IngestClipHeader header;
  header.set_parent("databases/" + database);
  header.set_file_name(name + ".bvh");
  header.set_label(label);
  v1::IngestClipResponse response;
  const grpc::Status status = Ingest(header, WriteBvh(figure), &response);
  INFO(status.error_message());
  REQUIRE(status.ok());
  return response;
}

v1::Operation TestServer::Wait(const std::string& operation) {
  v1::WaitOperationRequest request;
  request.set_name(operation);
  request.mutable_timeout()->set_seconds(60);
  const auto stub = NewStub<v1::OperationService>();
  const auto answer = Ask(*stub, &v1::OperationService::Stub::WaitOperation, request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  return answer.response.operation();
}

void TestServer::CreateTrained(const std::string& id) {
  CreateDatabase(id);
  gate_->Close();
  const auto first = IngestFigure(id, "walk", "walk", {.act = Act::kWalk, .frame_count = 120});
  IngestFigure(id, "squat", "squat", {.act = Act::kSquat, .frame_count = 120});
  const auto last = IngestFigure(id, "wave", "wave", {.act = Act::kWave, .frame_count = 120});
  if (first.operation().name() != last.operation().name()) {
    // On a slow machine a build has begun before the last clip: it must not make version 1.
    v1::CancelOperationRequest cancel;
    cancel.set_name(first.operation().name());
    const auto stub = NewStub<v1::OperationService>();
    REQUIRE(Ask(*stub, &v1::OperationService::Stub::CancelOperation, cancel).status.ok());
  }
  gate_->Open();
  const v1::Operation operation = Wait(last.operation().name());
  INFO(operation.ShortDebugString());
  REQUIRE(operation.state() == v1::OPERATION_STATE_SUCCEEDED);
}

bool IsDone(const v1::Operation& operation) {
  return operation.state() != v1::OPERATION_STATE_PENDING &&
         operation.state() != v1::OPERATION_STATE_RUNNING;
}

v1::DatabaseStatistics TestServer::Describe(const std::string& id) {
  v1::GetDatabaseRequest request;
  request.set_view(v1::DATABASE_VIEW_FULL);
  request.set_name("databases/" + id);
  const auto stub = NewStub<v1::DatabaseService>();
  const auto answer = Ask(*stub, &v1::DatabaseService::Stub::GetDatabase, request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  return answer.response.database().statistics();
}

v1::Observation WalkObservation() {
  v1::Observation observation;
  observation.mutable_file()->set_file_name("seen.bvh");
  observation.mutable_file()->set_data(
      WriteBvh({.act = Act::kWalk, .frame_count = 48, .phase = 0.3}));
  return observation;
}

std::string ViolatedFields(const grpc::Status& status) {
  v1::Status details;
  if (!details.ParseFromString(status.error_details())) return "(details do not parse)";
  std::string fields;
  for (const auto& detail : details.details()) {
    if (!detail.type_url().ends_with("/google.rpc.BadRequest")) continue;
    v1::BadRequest bad_request;
    if (!bad_request.ParseFromString(detail.value())) return "(detail does not parse)";
    for (const auto& violation : bad_request.field_violations()) {
      if (!fields.empty()) fields += ",";
      fields += violation.field();
    }
  }
  return fields;
}

}  // namespace motiondb::tests
