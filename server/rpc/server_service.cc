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

void SetDatabase(const DatabaseStatistics& statistics, v1::DatabaseStatus& status) {
  status.set_name(DatabaseName(statistics.name));
  status.set_clip_count(statistics.stored.clip_count);
  status.set_stored_frame_count(statistics.stored.frame_count);
  status.set_byte_count(statistics.stored.byte_count);
  if (statistics.model) {
    status.set_frame_count(statistics.model->frame_count);
    status.set_model_version(statistics.model->version);
    *status.mutable_model_age() = DurationOf(statistics.model_age_seconds);
    *status.mutable_model_build_time() = DurationOf(statistics.model->build_seconds);
  }
  if (statistics.operation) {
    status.set_operation(OperationName(statistics.operation->id));
    status.set_progress(statistics.operation->progress);
    status.set_stage(statistics.operation->stage);
  }
  status.set_open_stream_count(statistics.open_streams);
  status.set_succeeded_rebuild_count(statistics.rebuilds.succeeded);
  status.set_failed_rebuild_count(statistics.rebuilds.failed);
  status.set_cancelled_rebuild_count(statistics.rebuilds.cancelled);
  *status.mutable_rebuild_time() = DurationOf(statistics.rebuilds.seconds);
}

void SetMethod(const MethodStatistics& statistics, v1::MethodStatus& status) {
  status.set_method(statistics.method);
  status.set_call_count(statistics.ended);
  for (const auto& [code, count] : statistics.errors) {
    auto& error = *status.add_errors();
    error.set_code(static_cast<int>(code));
    error.set_call_count(count);
  }
  *status.mutable_p50_time() = DurationOf(statistics.seconds.p50);
  *status.mutable_p95_time() = DurationOf(statistics.seconds.p95);
  *status.mutable_p99_time() = DurationOf(statistics.seconds.p99);
}

void SetProcess(const ProcessStatistics& statistics, v1::GetServerStatusResponse& response) {
  response.set_memory_bytes(statistics.resident_bytes);
  *response.mutable_cpu_time() = DurationOf(statistics.cpu_seconds);
  response.set_thread_count(statistics.thread_count);
  response.set_open_file_count(statistics.open_descriptors);
  response.set_open_file_limit(statistics.max_descriptors);
}

absl::Status GetServerStatus(const Call& call, const v1::GetServerStatusRequest& request,
                             v1::GetServerStatusResponse& response) {
  (void)request;
  const ServerStatistics statistics = call.monitor.CollectStatistics();
  response.set_version(statistics.version);
  SetTimestamp(statistics.start_time_us, *response.mutable_start_time());
  response.set_serving(statistics.phase == Phase::kServing);
  response.set_encrypted(statistics.encrypted);
  response.set_authenticated(statistics.authenticated);
  if (statistics.certificate_expiry_s != 0) {
    response.mutable_certificate_end_time()->set_seconds(statistics.certificate_expiry_s);
  }
  response.set_call_count(statistics.ended_calls);
  response.set_failed_call_count(statistics.failed_calls);
  response.set_open_call_count(statistics.open_calls);
  response.set_open_stream_count(statistics.open_streams);
  response.set_queued_call_count(statistics.queued.requests + statistics.queued.heavy_requests);
  response.set_request_thread_count(statistics.request_threads);
  response.set_authentication_failure_count(statistics.authentication_failures);
  for (const MethodStatistics& method : statistics.methods)
    SetMethod(method, *response.add_methods());
  SetProcess(statistics.process, response);
  response.set_store_bytes(statistics.store_bytes);
  response.set_log_bytes(statistics.log_bytes);
  response.set_failed_write_count(statistics.write_failures.total());
  response.set_running_heavy_call_count(statistics.running_heavy_calls);
  if (const Readiness readiness = call.monitor.CheckReadiness(); !readiness.ready) {
    response.set_not_ready_reason(readiness.reason);
  }
  if (statistics.disk_bytes > 0) response.set_disk_bytes(statistics.disk_bytes);
  response.set_disk_free_bytes(statistics.disk_free_bytes);
  for (const DatabaseStatistics& database : statistics.databases) {
    SetDatabase(database, *response.add_databases());
  }
  for (const storage::Corruption& corruption : statistics.corruptions) {
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
