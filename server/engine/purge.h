// Removes what deleted clips leave on the disk.
#pragma once

#include <string>

#include "storage/motion_store.h"

namespace motiondb::server {

// Removes what is left of deleted clips that the current model does not know. What cannot be
// removed is logged and stays until the next time; unlogged, so does what was cancelled before its
// turn. REQUIRES: LiveDatabase::states_mutex is held, and the database is not deleted meanwhile
// (WhileAlive); or nobody knows it yet.
void PurgeDeletedClips(storage::MotionStore& store, const std::string& database,
                       const core::Cancelled& cancelled = {});

}  // namespace motiondb::server
