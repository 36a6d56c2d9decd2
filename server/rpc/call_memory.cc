#include "server/rpc/call_memory.h"

#include <fmt/format.h>

#include <chrono>

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
    return absl::ResourceExhaustedError(
        fmt::format("the call needs {:.1f} MiB of memory, more than the {:.1f} MiB for one client "
                    "(half of --message-memory-mib): send or ask for less",
                    Mebibytes(to), Mebibytes(client_limit_)));
  }
  const storage::MutexLock lock(mutex_);
  const std::int64_t more = to - from;
  const auto own = per_client_.find(client);
  const std::int64_t of_client = own == per_client_.end() ? 0 : own->second;
  const bool fits_client = of_client + more <= client_limit_;
  if (more > 0 && !(fits_client && reserved_ + more <= limit_)) {
    return core::WithReason(
        "OUT_OF_MEMORY",
        RetryLater(std::chrono::seconds(1),
                   "{:.1f} MiB more do not fit: {} reserve {:.1f} of {:.1f} MiB "
                   "(--message-memory-mib); try again in a second",
                   Mebibytes(more), fits_client ? "all calls" : "calls of this client",
                   Mebibytes(fits_client ? reserved_ : of_client),
                   Mebibytes(fits_client ? limit_ : client_limit_)));
  }
  Add(client, more);
  return absl::OkStatus();
}

void CallMemory::Add(const std::string& client, std::int64_t bytes) {
  reserved_ += bytes;
  const auto own = per_client_.try_emplace(client, 0).first;
  own->second += bytes;
  if (own->second == 0) per_client_.erase(own);
}

std::int64_t MostOfOneCall(std::int64_t size_bytes) {
  constexpr std::int64_t kOfAnyCall = 48 << 20;
  constexpr std::int64_t kTimesItsSize = 9;
  return kOfAnyCall + kTimesItsSize * size_bytes;
}

}  // namespace motiondb::server
