#include "server/translate/operation_message.h"

#include "motiondb/v1/operation.pb.h"
#include "server/translate/resource_name.h"
#include "server/translate/timestamp.h"
#include "text/display_text.h"

namespace motiondb::server {
namespace {

v1::OperationState ToProto(storage::OperationState state) {
  switch (state) {
    case storage::OperationState::kPending:
      return v1::OPERATION_STATE_PENDING;
    case storage::OperationState::kRunning:
      return v1::OPERATION_STATE_RUNNING;
    case storage::OperationState::kSucceeded:
      return v1::OPERATION_STATE_SUCCEEDED;
    case storage::OperationState::kFailed:
      return v1::OPERATION_STATE_FAILED;
    case storage::OperationState::kCancelled:
      return v1::OPERATION_STATE_CANCELLED;
  }
  return v1::OPERATION_STATE_UNSPECIFIED;
}

}  // namespace

void SetOperation(const storage::OperationRecord& record, v1::Operation& message) {
  message.set_name(OperationName(record.id));
  message.set_database(DatabaseName(record.database));
  message.set_state(ToProto(record.state));
  message.set_done(record.done());
  message.set_progress(record.progress);
  message.set_stage(record.stage);
  if (record.model_version > 0) message.set_model(ModelName(record.database, record.model_version));
  if (record.error_code != 0) {
    message.mutable_error()->set_code(record.error_code);
    message.mutable_error()->set_message(text::SafeText(record.error_message));
  }
  SetTimestamp(record.create_time_us, *message.mutable_create_time());
  SetTimestamp(record.update_time_us, *message.mutable_update_time());
}

}  // namespace motiondb::server
