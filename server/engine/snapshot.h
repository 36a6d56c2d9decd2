// A model with its version and figures. Immutable; queries share it and hold on to it.
#pragma once

#include "core/model/model.h"
#include "storage/records.h"

namespace motiondb::server {

struct Snapshot {
  storage::ModelRecord record;
  core::Model model;
};

}  // namespace motiondb::server
