#include "server/rpc/call_limits.h"

#include <fmt/format.h>

#include <string_view>

#include "core/motion/error.h"
#include "server/translate/status_mapping.h"

namespace motiondb::server {
namespace {

struct ClassTexts {
  std::string_view noun;
  std::string_view in_all;  // the limit
  std::string_view per_client;
  std::chrono::milliseconds retry_after;  // about the duration of one call
};

constexpr ClassTexts kClassTexts[] = {
    {"calls", "--max-calls", "a quarter of --max-calls", std::chrono::milliseconds(100)},
    {"heavy calls", "--max-heavy-calls", "a quarter of --max-heavy-calls",
     std::chrono::milliseconds(1000)},
    {"streams", "a quarter of --max-calls", "a 16th of --max-calls",
     std::chrono::milliseconds(10'000)}};

constexpr std::size_t Index(RequestClass request_class) {
  return static_cast<std::size_t>(request_class);
}

absl::Status TooMany(const ClassTexts& texts, int open, std::string_view whose,
                     std::string_view limit) {
  return core::WithReason(
      "TOO_MANY_CALLS",
      RetryLater(texts.retry_after,
                 "too many {}: {} in flight {}, the maximum ({}); retry in {:g} s or when "
                 "one has ended",
                 texts.noun, open, whose, limit,
                 std::chrono::duration<double>(texts.retry_after).count()));
}

}  // namespace

CallLimits::Slot& CallLimits::Slot::operator=(Slot&& other) noexcept {
  std::swap(limits_, other.limits_);
  std::swap(request_class_, other.request_class_);
  client_.swap(other.client_);
  return *this;
}

void CallLimits::Slot::Release() {
  if (limits_ != nullptr) limits_->Leave(request_class_, client_);
  limits_ = nullptr;
}

absl::StatusOr<CallLimits::Slot> CallLimits::Enter(RequestClass request_class,
                                                   const std::string& client) {
  const std::size_t i = Index(request_class);
  const storage::MutexLock lock(mutex_);
  const ClassTexts& texts = kClassTexts[i];
  if (in_all_[i] >= limits_[i].in_all) return TooMany(texts, in_all_[i], "in total", texts.in_all);
  const auto entry = per_client_.find(client);
  if (entry != per_client_.end() && entry->second[i] >= limits_[i].per_client) {
    return TooMany(texts, entry->second[i], "for this client", texts.per_client);
  }
  ++in_all_[i];
  ++(entry == per_client_.end() ? per_client_[client] : entry->second)[i];
  Slot slot;
  slot.limits_ = this;
  slot.request_class_ = request_class;
  slot.client_ = client;
  return slot;
}

absl::Status CallLimits::CheckMetadata(std::size_t bytes) const {
  if (bytes <= static_cast<std::size_t>(options_.max_metadata_bytes)) return absl::OkStatus();
  return absl::ResourceExhaustedError(fmt::format("expected at most {} bytes of metadata, got {}",
                                                  options_.max_metadata_bytes, bytes));
}

int CallLimits::open(RequestClass request_class) const {
  const storage::MutexLock lock(mutex_);
  return in_all_[Index(request_class)];
}

void CallLimits::Leave(RequestClass request_class, const std::string& client) {
  const storage::MutexLock lock(mutex_);
  --in_all_[Index(request_class)];
  const auto entry = per_client_.find(client);
  --entry->second[Index(request_class)];
  if (std::ranges::all_of(entry->second, [](int count) { return count == 0; })) {
    per_client_.erase(entry);
  }
}

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
