#include "server/engine/damage_book.h"

#include <spdlog/spdlog.h>

#include <algorithm>

namespace motiondb::server {

void DamageBook::Note(const storage::Damage& damage) {
  const storage::MutexLock lock(mutex_);
  const bool known = std::ranges::any_of(damages_, [&](const storage::Damage& other) {
    return other.resource == damage.resource && other.description == damage.description;
  });
  if (known || damages_.size() >= kLimit) return;
  damages_.push_back(damage);
  spdlog::error("corruption found: {}{}{}", damage.resource, damage.resource.empty() ? "" : ": ",
                damage.description);
}

std::vector<storage::Damage> DamageBook::List() const {
  const storage::MutexLock lock(mutex_);
  return damages_;
}

}  // namespace motiondb::server
