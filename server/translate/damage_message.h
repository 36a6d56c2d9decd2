// What was found damaged, as a message. Safe to call from any thread.
#pragma once

#include "storage/store_upkeep.h"

namespace motiondb::v1 {
class Damage;
}

namespace motiondb::server {

// Texts come from a file that may hold anything: as much as a person reads of them.
void SetDamage(const storage::Damage& damage, v1::Damage& message);

}  // namespace motiondb::server
