// A store in memory. Writes of operations wait for a gate.
#pragma once

#include <memory>
#include <utility>

#include "core/model/model.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/support/gated_store.h"

namespace motiondb::tests {

class SlowStore final : public GatedStore {
 public:
  explicit SlowStore(std::shared_ptr<Gate> disk)
      : GatedStore(*storage::SqliteMotionStore::Open(":memory:"), std::make_shared<Gate>()),
        disk_(std::move(disk)) {}
  absl::Status PutOperation(const storage::OperationRecord& record,
                            const core::Cancelled& cancelled = {}) override {
    disk_->Pass();
    return GatedStore::PutOperation(record, cancelled);
  }

 private:
  const std::shared_ptr<Gate> disk_;
};

}  // namespace motiondb::tests
