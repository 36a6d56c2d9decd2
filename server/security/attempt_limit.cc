#include "server/security/attempt_limit.h"

#include <arpa/inet.h>

#include <algorithm>

namespace motiondb::server {

bool AttemptLimit::Count(const std::string& source, Clock::time_point now) {
  const storage::MutexLock lock(mutex_);
  auto found = windows_.find(source);
  if (found == windows_.end()) {
    MakeRoom(now);
    found = windows_.emplace(source, Window{now}).first;
  } else if (now - found->second.began >= window_) {
    found->second = {now};
  }
  Window& window = found->second;
  window.count = std::min(window.count + 1, max_count_ + 1);
  return window.count <= max_count_;
}

std::chrono::milliseconds AttemptLimit::Wait(const std::string& source,
                                             Clock::time_point now) const {
  const storage::MutexLock lock(mutex_);
  const auto found = windows_.find(source);
  if (found == windows_.end() || found->second.count < max_count_) return {};
  const auto rest = found->second.began + window_ - now;
  return std::max(std::chrono::ceil<std::chrono::milliseconds>(rest), std::chrono::milliseconds(0));
}

std::size_t AttemptLimit::size() const {
  const storage::MutexLock lock(mutex_);
  return windows_.size();
}

void AttemptLimit::MakeRoom(Clock::time_point now) {
  if (windows_.size() < capacity_) return;
  std::erase_if(windows_, [&](const auto& entry) { return now - entry.second.began >= window_; });
  if (windows_.size() < capacity_) return;
  windows_.erase(
      std::ranges::min_element(windows_, {}, [](const auto& entry) { return entry.second.began; }));
}

std::string AttemptSource(const std::string& address) {
  in6_addr parsed;
  if (inet_pton(AF_INET6, address.c_str(), &parsed) != 1) return address;
  if (IN6_IS_ADDR_V4MAPPED(&parsed)) return address;
  std::fill(std::begin(parsed.s6_addr) + 8, std::end(parsed.s6_addr), std::uint8_t{0});
  char text[INET6_ADDRSTRLEN];
  return inet_ntop(AF_INET6, &parsed, text, sizeof text);
}

}  // namespace motiondb::server
