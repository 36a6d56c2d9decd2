#include <google/protobuf/util/time_util.h>

#include <cmath>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "motiondb/v1/store.grpc.pb.h"
#include "motiondb/v1/store.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/services.h"
#include "server/rpc/stream_reactor.h"
#include "server/translate/message_fields.h"
#include "server/translate/record_messages.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {
namespace {

absl::StatusOr<NextMessage<v1::BackupStoreResponse>> OpenBackup(const Call& call,
                                                                const v1::BackupStoreRequest&) {
  MOTIONDB_ASSIGN_OR_RETURN(auto made, call.engine.store().upkeep().BeginBackup(call.cancelled));
  std::shared_ptr<storage::StoreBackup> backup = std::move(made);
  return [backup, first = true](v1::BackupStoreResponse& message) mutable -> absl::StatusOr<bool> {
    if (std::exchange(first, false)) message.set_total_bytes(backup->total_bytes());
    return backup->Read(*message.mutable_block());
  };
}

void SetSummary(const storage::VerifyTotals& totals, v1::VerifySummary& summary) {
  summary.set_database_count(totals.database_count);
  summary.set_clip_count(totals.clip_count);
  summary.set_model_count(totals.model_count);
  summary.set_skeleton_count(totals.skeleton_count);
  summary.set_byte_count(totals.byte_count);
  summary.set_damage_count(totals.damage_count);
}

// Makes the messages of one verification: corrupt items, progress in between, and a summary.
class Verification {
 public:
  Verification(Engine& engine, std::unique_ptr<storage::StoreVerifier> verifier)
      : engine_(engine), verifier_(std::move(verifier)) {}

  absl::StatusOr<bool> Next(v1::VerifyStoreResponse& message) {
    if (summary_sent_) return false;
    if (found_.empty() && more_) MOTIONDB_RETURN_IF_ERROR(Step());
    if (!found_.empty()) {
      SetDamage(found_.front(), *message.mutable_damage());
      found_.pop_front();
    } else if (more_) {
      message.set_progress(verifier_->progress());
    } else {
      SetSummary(verifier_->totals(), *message.mutable_summary());
      summary_sent_ = true;
    }
    return true;
  }

 private:
  absl::Status Step() {
    std::vector<storage::Damage> found;
    MOTIONDB_ASSIGN_OR_RETURN(more_, verifier_->Step(found));
    for (storage::Damage& damage : found) {
      engine_.NoteDamage(damage);
      found_.push_back(std::move(damage));
    }
    return absl::OkStatus();
  }

  Engine& engine_;
  const std::unique_ptr<storage::StoreVerifier> verifier_;
  std::deque<storage::Damage> found_;  // not sent yet
  bool more_ = true;
  bool summary_sent_ = false;
};

absl::StatusOr<NextMessage<v1::VerifyStoreResponse>> OpenVerify(const Call& call,
                                                                const v1::VerifyStoreRequest&) {
  MOTIONDB_ASSIGN_OR_RETURN(auto verifier,
                            call.engine.store().upkeep().BeginVerify(call.cancelled));
  auto verification = std::make_shared<Verification>(call.engine, std::move(verifier));
  return [verification](v1::VerifyStoreResponse& message) { return verification->Next(message); };
}

google::protobuf::Duration DurationOf(double seconds) {
  return google::protobuf::util::TimeUtil::MicrosecondsToDuration(std::llround(seconds * 1e6));
}

void SetDatabase(const DatabaseFigures& figures, v1::DatabaseStatus& status) {
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

void SetMethod(const MethodFigures& figures, v1::MethodStatus& status) {
  status.set_method(figures.method);
  status.set_call_count(figures.ended);
  for (const auto& [code, count] : figures.errors) {
    auto& error = *status.add_errors();
    error.set_code(std::string(CodeName(code)));
    error.set_call_count(count);
  }
  *status.mutable_p50_time() = DurationOf(figures.seconds.p50);
  *status.mutable_p95_time() = DurationOf(figures.seconds.p95);
  *status.mutable_p99_time() = DurationOf(figures.seconds.p99);
}

void SetProcess(const ProcessFigures& figures, v1::GetServerStatusResponse& response) {
  response.set_memory_bytes(figures.resident_bytes);
  *response.mutable_cpu_time() = DurationOf(figures.cpu_seconds);
  response.set_thread_count(figures.thread_count);
  response.set_open_file_count(figures.open_descriptors);
  response.set_open_file_limit(figures.max_descriptors);
}

absl::Status GetServerStatus(const Call& call, const v1::GetServerStatusRequest& request,
                             v1::GetServerStatusResponse& response) {
  (void)request;
  const ServerFigures figures = call.monitor.Figures();
  response.set_version(figures.version);
  SetTimestamp(figures.start_time_us, *response.mutable_start_time());
  response.set_serving(figures.phase == Phase::kServing);
  response.set_encrypted(figures.encrypted);
  response.set_authenticated(figures.authenticated);
  if (figures.certificate_end_time_s != 0) {
    response.mutable_certificate_end_time()->set_seconds(figures.certificate_end_time_s);
  }
  response.set_call_count(figures.ended_calls);
  response.set_failed_call_count(figures.failed_calls);
  response.set_open_call_count(figures.open_calls);
  response.set_open_stream_count(figures.open_streams);
  response.set_queued_call_count(figures.queued.requests + figures.queued.heavy_requests);
  response.set_request_thread_count(figures.request_threads);
  response.set_authentication_failure_count(figures.authentication_failures);
  for (const MethodFigures& method : figures.methods) SetMethod(method, *response.add_methods());
  SetProcess(figures.process, response);
  response.set_store_bytes(figures.store_bytes);
  response.set_log_bytes(figures.log_bytes);
  response.set_failed_write_count(figures.write_failures.total());
  response.set_running_heavy_call_count(figures.running_heavy_calls);
  if (const Readiness readiness = call.monitor.CheckReadiness(); !readiness.ready) {
    response.set_not_ready_reason(readiness.reason);
  }
  response.set_disk_bytes(figures.disk_bytes);
  response.set_disk_free_bytes(figures.disk_free_bytes);
  for (const DatabaseFigures& database : figures.databases) {
    SetDatabase(database, *response.add_databases());
  }
  for (const storage::Damage& damage : figures.damages) {
    SetDamage(damage, *response.add_damages());
  }
  return absl::OkStatus();
}

class StoreServiceImpl final : public v1::StoreService::CallbackService {
 public:
  explicit StoreServiceImpl(CallHost& host) : host_(host) {}

  grpc::ServerUnaryReactor* GetServerStatus(grpc::CallbackServerContext* context,
                                            const v1::GetServerStatusRequest* request,
                                            v1::GetServerStatusResponse* response) override {
    return Answer<server::GetServerStatus>(host_, context, request, response);
  }
  grpc::ServerWriteReactor<v1::VerifyStoreResponse>* VerifyStore(
      grpc::CallbackServerContext* context, const v1::VerifyStoreRequest* request) override {
    return new StreamReactor<v1::VerifyStoreRequest, v1::VerifyStoreResponse>(host_, context,
                                                                              request, OpenVerify);
  }
  grpc::ServerWriteReactor<v1::BackupStoreResponse>* BackupStore(
      grpc::CallbackServerContext* context, const v1::BackupStoreRequest* request) override {
    return new StreamReactor<v1::BackupStoreRequest, v1::BackupStoreResponse>(host_, context,
                                                                              request, OpenBackup);
  }
  grpc::ServerReadReactor<v1::RestoreStoreRequest>* RestoreStore(
      grpc::CallbackServerContext* context, v1::RestoreStoreResponse* response) override {
    return NewRestoreReactor(host_, *context, *response);
  }

 private:
  CallHost& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeStoreService(CallHost& host) {
  return std::make_unique<StoreServiceImpl>(host);
}

}  // namespace motiondb::server
