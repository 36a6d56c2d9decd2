#include "client/reconnect.h"

#include <motiondb/call_error.h>

#include <algorithm>
#include <random>

namespace motiondb::client {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirstDelay{200};
constexpr milliseconds kMaxDelay{10'000};
constexpr int kMaxDoublings = 6;  // from kFirstDelay beyond kMaxDelay

// Between 80 % and 100 %, so that the clients of a restarted server do not return together.
milliseconds Jittered(milliseconds delay) {
  thread_local std::minstd_rand random{std::random_device{}()};
  return milliseconds(std::uniform_int_distribution<int>(static_cast<int>(delay.count()) * 4 / 5,
                                                         static_cast<int>(delay.count()))(random));
}

}  // namespace

ReconnectDelays::ReconnectDelays(int address_count) : other_addresses_(address_count - 1) {}

std::optional<milliseconds> ReconnectDelays::Next(const absl::Status& error) {
  const auto server_delay = RetryDelay(error);
  if (!absl::IsUnavailable(error) && !server_delay) return std::nullopt;
  const int doublings = std::min(attempts_++ - other_addresses_, kMaxDoublings);
  const milliseconds delay = doublings < 0
                                 ? milliseconds(0)
                                 : Jittered(std::min(kFirstDelay * (1 << doublings), kMaxDelay));
  return std::max(delay, server_delay.value_or(milliseconds(0)));
}

void ReconnectDelays::Reset() { attempts_ = 0; }

}  // namespace motiondb::client
