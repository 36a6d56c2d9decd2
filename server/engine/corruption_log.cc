#include "server/engine/corruption_log.h"

#include <spdlog/spdlog.h>

#include <algorithm>

namespace motiondb::server {

void CorruptionLog::Note(const storage::Corruption& corruption) {
  const storage::MutexLock lock(mutex_);
  const bool known = std::ranges::any_of(corruptions_, [&](const storage::Corruption& other) {
    return other.resource == corruption.resource && other.description == corruption.description;
  });
  if (known || corruptions_.size() >= kLimit) return;
  corruptions_.push_back(corruption);
  spdlog::error("corruption found: {}{}{}", corruption.resource,
                corruption.resource.empty() ? "" : ": ", corruption.description);
}

std::vector<storage::Corruption> CorruptionLog::List() const {
  const storage::MutexLock lock(mutex_);
  return corruptions_;
}

}  // namespace motiondb::server
