#include <google/protobuf/util/time_util.h>

#include <cmath>
#include <memory>

#include "motiondb/v1/server.grpc.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/services.h"
#include "server/translate/message_fields.h"
#include "server/translate/record_messages.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {
namespace {

google::protobuf::Duration DurationOf(double seconds) {
  return google::protobuf::util::TimeUtil::MicrosecondsToDuration(std::llround(seconds * 1e6));
}

void SetDatabase(const DatabaseStatistics& figures, v1::DatabaseStatus& status) {
  status.set_name(DatabaseName(figures.name));
  status.set_clip_count(figures.stored.clip_count);
  status.set_stored_frame_count(figures.stored.frame_count);
  status.set_byte_count(figures.stored.byte_count);
  if (figures.model) {
    status.set_frame_count(figures.model->frame_count);
    status.set_model_version(figures.model->version);
    *status.mutable_model_age() = DurationOf(figures.model_age_seconds);
    *status.mutable_model_build_time() = DurationOf(figures.model->build_seconds);
  }
  if (figures.operation) {
    status.set_operation(OperationName(figures.operation->id));
    status.set_progress(figures.operation->progress);
    status.set_stage(figures.operation->stage);
  }
  status.set_open_stream_count(figures.open_streams);
  status.set_succeeded_rebuild_count(figures.rebuilds.succeeded);
  status.set_failed_rebuild_count(figures.rebuilds.failed);
  status.set_cancelled_rebuild_count(figures.rebuilds.cancelled);
  *status.mutable_rebuild_time() = DurationOf(figures.rebuilds.seconds);
}

void SetMethod(const MethodStatistics& figures, v1::MethodStatus& status) {
  status.set_method(figures.method);
  status.set_call_count(figures.ended);
  for (const auto& [code, count] : figures.errors) {
    auto& error = *status.add_errors();
    error.set_code(static_cast<int>(code));
    error.set_call_count(count);
  }
  *status.mutable_p50_time() = DurationOf(figures.seconds.p50);
  *status.mutable_p95_time() = DurationOf(figures.seconds.p95);
  *status.mutable_p99_time() = DurationOf(figures.seconds.p99);
}

void SetProcess(const ProcessStatistics& figures, v1::GetServerStatusResponse& response) {
  response.set_memory_bytes(figures.resident_bytes);
  *response.mutable_cpu_time() = DurationOf(figures.cpu_seconds);
  response.set_thread_count(figures.thread_count);
  response.set_open_file_count(figures.open_descriptors);
  response.set_open_file_limit(figures.max_descriptors);
}

absl::Status GetServerStatus(const Call& call, const v1::GetServerStatusRequest& request,
                             v1::GetServerStatusResponse& response) {
  (void)request;
  const ServerStatistics figures = call.monitor.CollectStatistics();
  response.set_version(figures.version);
  SetTimestamp(figures.start_time_us, *response.mutable_start_time());
  response.set_serving(figures.phase == Phase::kServing);
  response.set_encrypted(figures.encrypted);
  response.set_authenticated(figures.authenticated);
  if (figures.certificate_expiry_s != 0) {
    response.mutable_certificate_end_time()->set_seconds(figures.certificate_expiry_s);
  }
  response.set_call_count(figures.ended_calls);
  response.set_failed_call_count(figures.failed_calls);
  response.set_open_call_count(figures.open_calls);
  response.set_open_stream_count(figures.open_streams);
  response.set_queued_call_count(figures.queued.requests + figures.queued.heavy_requests);
  response.set_request_thread_count(figures.request_threads);
  response.set_authentication_failure_count(figures.authentication_failures);
  for (const MethodStatistics& method : figures.methods) SetMethod(method, *response.add_methods());
  SetProcess(figures.process, response);
  response.set_store_bytes(figures.store_bytes);
  response.set_log_bytes(figures.log_bytes);
  response.set_failed_write_count(figures.write_failures.total());
  response.set_running_heavy_call_count(figures.running_heavy_calls);
  if (const Readiness readiness = call.monitor.CheckReadiness(); !readiness.ready) {
    response.set_not_ready_reason(readiness.reason);
  }
  if (figures.disk_bytes > 0) response.set_disk_bytes(figures.disk_bytes);
  response.set_disk_free_bytes(figures.disk_free_bytes);
  for (const DatabaseStatistics& database : figures.databases) {
    SetDatabase(database, *response.add_databases());
  }
  for (const storage::Corruption& corruption : figures.corruptions) {
    SetCorruption(corruption, *response.add_corruptions());
  }
  return absl::OkStatus();
}

class ServerServiceImpl final : public v1::ServerService::CallbackService {
 public:
  explicit ServerServiceImpl(ServiceContext& host) : host_(host) {}

  grpc::ServerUnaryReactor* GetServerStatus(grpc::CallbackServerContext* context,
                                            const v1::GetServerStatusRequest* request,
                                            v1::GetServerStatusResponse* response) override {
    return Answer<server::GetServerStatus>(host_, context, request, response);
  }

 private:
  ServiceContext& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeServerService(ServiceContext& host) {
  return std::make_unique<ServerServiceImpl>(host);
}

}  // namespace motiondb::server
