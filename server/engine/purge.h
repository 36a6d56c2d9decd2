// Removes what deleted clips leave on the disk.
#pragma once

#include <string>

#include "storage/motion_store.h"

namespace motiondb::server {

// Removes what is left of deleted clips that the current model does not know. What cannot be
// removed is logged and stays until the next time. REQUIRES: no build of the database is under way,
// and it is not deleted meanwhile (LiveDatabase::WhileAlive).
void PurgeDeletedClips(storage::MotionStore& store, const std::string& database);

}  // namespace motiondb::server
