#include "server/rpc/message_memory.h"

#include <fmt/format.h>

#include <chrono>

#include "server/translate/retry_info.h"

namespace motiondb::server {
namespace {

double Mebibytes(std::int64_t bytes) { return static_cast<double>(bytes) / (1 << 20); }

}  // namespace

MessageMemory::Share::~Share() { memory_.Change(held_, 0).IgnoreError(); }

absl::Status MessageMemory::Share::Hold(std::int64_t bytes) {
  absl::Status changed = memory_.Change(held_, bytes);
  if (changed.ok()) held_ = bytes;
  return changed;
}

std::int64_t MessageMemory::held() const {
  const std::lock_guard lock(mutex_);
  return held_;
}

absl::Status MessageMemory::Change(std::int64_t from, std::int64_t to) {
  if (to > limit_) {
    return absl::ResourceExhaustedError(
        fmt::format("{:.1f} MiB of messages would be held for this call, more than the "
                    "{:.1f} MiB for all (--message-memory-mib): send or ask for less",
                    Mebibytes(to), Mebibytes(limit_)));
  }
  const std::lock_guard lock(mutex_);
  const std::int64_t others = held_ - from;
  if (to > from && others + to > limit_) {
    return RetryLater(std::chrono::seconds(1),
                      "{:.1f} MiB of messages are on their way, and with {:.1f} more there "
                      "would be more than there may be (--message-memory-mib): try again in a "
                      "second, when some have been dealt with",
                      Mebibytes(held_), Mebibytes(to - from));
  }
  held_ = others + to;
  return absl::OkStatus();
}

}  // namespace motiondb::server
