// On what terms something in a store is changed.
#pragma once

#include "core/motion/cancellation.h"

namespace motiondb::storage {

struct AuditRecord;

struct ChangeTerms {
  // The entry in the record of changes: kept with the change, or neither is. Null: there is none.
  const AuditRecord* audit = nullptr;
  // Asked while the change waits for its turn, and not once it is being made: CANCELLED, with
  // nothing changed.
  core::Cancelled cancelled;
};

}  // namespace motiondb::storage
