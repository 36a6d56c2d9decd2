// Operations as messages. Safe to call from any thread.
#pragma once

#include "storage/records.h"

namespace motiondb::v1 {
class Operation;
}

namespace motiondb::server {

void SetOperation(const storage::OperationRecord& record, v1::Operation& message);

}  // namespace motiondb::server
