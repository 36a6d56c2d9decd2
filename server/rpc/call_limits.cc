#include "server/rpc/call_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <string_view>
#include <utility>

#include "server/translate/status_mapping.h"

namespace motiondb::server {
namespace {

struct Words {
  std::string_view what;
  std::string_view setting;
  std::chrono::milliseconds retry_after;  // about how long one takes to end
};

constexpr Words kWords[] = {{"calls", "calls", std::chrono::milliseconds(100)},
                            {"heavy calls", "heavy-calls", std::chrono::milliseconds(1000)},
                            {"streams", "streams", std::chrono::milliseconds(10'000)}};

constexpr std::size_t Index(RequestClass request_class) {
  return static_cast<std::size_t>(request_class);
}

absl::Status TooMany(const Words& words, int open, std::string_view whose, std::string_view share) {
  return core::WithReason(
      "TOO_MANY_CALLS",
      RetryLater(words.retry_after,
                 "{} {} are under way {}, as many as there may be ({}--max-{}): try again in "
                 "{:g} s, or when one has ended",
                 open, words.what, whose, share, words.setting,
                 std::chrono::duration<double>(words.retry_after).count()));
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
  if (in_all_[i] >= limits_[i].in_all) return TooMany(kWords[i], in_all_[i], "in all", "");
  const auto own = per_client_.find(client);
  if (own != per_client_.end() && own->second[i] >= limits_[i].per_client) {
    return TooMany(kWords[i], own->second[i], "for this client", "a quarter of ");
  }
  ++in_all_[i];
  ++(own == per_client_.end() ? per_client_[client] : own->second)[i];
  Slot slot;
  slot.limits_ = this;
  slot.request_class_ = request_class;
  slot.client_ = client;
  return slot;
}

absl::Status CallLimits::CheckMetadata(std::size_t bytes) const {
  if (bytes <= static_cast<std::size_t>(options_.max_metadata_bytes)) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      fmt::format("the call comes with {} bytes of metadata, more than the {} that it may: "
                  "try again with less",
                  bytes, options_.max_metadata_bytes));
}

int CallLimits::open(RequestClass request_class) const {
  const storage::MutexLock lock(mutex_);
  return in_all_[Index(request_class)];
}

void CallLimits::Leave(RequestClass request_class, const std::string& client) {
  const storage::MutexLock lock(mutex_);
  --in_all_[Index(request_class)];
  const auto own = per_client_.find(client);
  --own->second[Index(request_class)];
  if (std::ranges::all_of(own->second, [](int count) { return count == 0; })) {
    per_client_.erase(own);
  }
}

}  // namespace motiondb::server
