// Steps that the calls which edit clips and segments have in common.
#pragma once

#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "core/motion/error.h"
#include "server/rpc/call.h"
#include "server/translate/annotation_request.h"
#include "server/translate/record_messages.h"

namespace motiondb::server {

// Sets revision and operation of the response. An edit without effect is recorded as unchanged.
template <typename Response>
void SetEdited(const Call& call, const Edited& edited, Response& response) {
  if (edited.edit.id == 0) call.entry.SetUnchanged();
  response.set_revision(edited.revision);
  if (edited.operation) SetOperation(*edited.operation, *response.mutable_operation());
}

// Makes one change, sets the response as above, and returns the edit. `resource`: for the audit
// log.
template <typename Response>
absl::StatusOr<storage::EditRecord> MakeChange(const Call& call, const RequestedChange& requested,
                                               const std::string& resource, Response& response) {
  const auto audit = call.entry.AuditRecordForChange(resource);
  MOTIONDB_ASSIGN_OR_RETURN(
      Edited edited, call.engine.Edit(requested.database, {&requested.change, 1}, audit.principal,
                                      {&audit, call.cancelled}));
  SetEdited(call, edited, response);
  return std::move(edited.edit);
}

}  // namespace motiondb::server
