#include "server/rpc/server_status.h"

#include <google/protobuf/util/time_util.h>

#include <cmath>

#include "server/translate/damage_message.h"
#include "server/translate/resource_name.h"
#include "server/translate/timestamp.h"

namespace motiondb::server {
namespace {

void SetDatabase(const DatabaseFigures& figures, v1::DatabaseStatus& status) {
  status.set_name(DatabaseName(figures.name));
  status.set_clip_count(figures.stored.clip_count);
  if (figures.model) {
    status.set_frame_count(figures.model->frame_count);
    status.set_model_version(figures.model->version);
    *status.mutable_model_age() = google::protobuf::util::TimeUtil::MillisecondsToDuration(
        std::llround(figures.model_age_seconds * 1000));
  }
  if (figures.operation) {
    status.set_operation(OperationName(figures.operation->id));
    status.set_progress(figures.operation->progress);
    status.set_stage(figures.operation->stage);
  }
}

}  // namespace

absl::Status GetServerStatus(const Call& call, const v1::GetServerStatusRequest& request,
                             v1::GetServerStatusResponse& response) {
  (void)request;
  const ServerFigures figures = call.monitor.Figures();
  response.set_version(figures.version);
  SetTimestamp(figures.start_time_us, *response.mutable_start_time());
  response.set_serving(figures.phase == Phase::kServing);
  response.set_encrypted(figures.encrypted);
  response.set_authenticated(figures.authenticated);
  response.set_call_count(figures.ended_calls);
  response.set_failed_call_count(figures.failed_calls);
  response.set_open_call_count(figures.open_calls);
  response.set_open_stream_count(figures.open_streams);
  response.set_queued_call_count(figures.queued_calls);
  response.set_memory_bytes(figures.process.resident_bytes);
  response.set_store_bytes(figures.store_bytes);
  response.set_log_bytes(figures.log_bytes);
  for (const DatabaseFigures& database : figures.databases) {
    SetDatabase(database, *response.add_databases());
  }
  for (const storage::Damage& damage : figures.damages) {
    SetDamage(damage, *response.add_damages());
  }
  return absl::OkStatus();
}

}  // namespace motiondb::server
