#include "server/rpc/call_memory.h"

#include <fmt/format.h>

#include <chrono>

#include "core/motion/error.h"
#include "server/translate/status_mapping.h"

namespace motiondb::server {

CallMemory::Reservation::~Reservation() { Resize(0).IgnoreError(); }

absl::Status CallMemory::Reservation::Resize(std::int64_t bytes) {
  if (bytes == bytes_) return absl::OkStatus();
  absl::Status changed = memory_.Change(client_, bytes_, bytes);
  if (changed.ok()) bytes_ = bytes;
  return changed;
}

void CallMemory::Reservation::SetClient(const std::string& client) {
  if (bytes_ > 0 && client != client_) {
    const storage::MutexLock lock(memory_.mutex_);
    memory_.Add(client_, -bytes_);
    memory_.Add(client, bytes_);
  }
  client_ = client;
}

std::int64_t CallMemory::reserved() const {
  const storage::MutexLock lock(mutex_);
  return reserved_;
}

absl::Status CallMemory::Change(const std::string& client, std::int64_t from, std::int64_t to) {
  if (to > client_limit_) {
    return core::WithReason(
        "CALL_TOO_LARGE",
        absl::ResourceExhaustedError(fmt::format(
            "the call needs {:.1f} MiB of memory, more than the {:.1f} MiB for one client "
            "(half of --message-memory-mib): send or request less",
            Mebibytes(to), Mebibytes(client_limit_))));
  }
  const storage::MutexLock lock(mutex_);
  const std::int64_t increase = to - from;
  const auto entry = per_client_.find(client);
  const std::int64_t client_bytes = entry == per_client_.end() ? 0 : entry->second;
  const bool fits_client = client_bytes + increase <= client_limit_;
  if (increase > 0 && !(fits_client && reserved_ + increase <= limit_)) {
    return core::WithReason(
        "OUT_OF_MEMORY",
        RetryLater(std::chrono::seconds(1),
                   "not enough memory for {:.1f} MiB more: {} reserve {:.1f} of {:.1f} MiB "
                   "(--message-memory-mib); retry in 1 s",
                   Mebibytes(increase), fits_client ? "all calls" : "calls of this client",
                   Mebibytes(fits_client ? reserved_ : client_bytes),
                   Mebibytes(fits_client ? limit_ : client_limit_)));
  }
  Add(client, increase);
  return absl::OkStatus();
}

void CallMemory::Add(const std::string& client, std::int64_t bytes) {
  reserved_ += bytes;
  const auto entry = per_client_.try_emplace(client, 0).first;
  entry->second += bytes;
  if (entry->second == 0) per_client_.erase(entry);
}

std::int64_t MaxCallMemory(std::int64_t size_bytes) {
  constexpr std::int64_t kBase = 48 << 20;
  constexpr std::int64_t kFactor = 9;
  return kBase + kFactor * size_bytes;
}

}  // namespace motiondb::server
