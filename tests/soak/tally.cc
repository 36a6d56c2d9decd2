#include "tests/soak/tally.h"

#include <algorithm>

namespace motiondb::tests {
namespace {
constexpr std::size_t kMaxFaults = 20;
}

void Tally::Add(const std::string& call, const absl::Status& status,
                std::initializer_list<absl::StatusCode> expected) {
  const std::lock_guard lock(mutex_);
  ++counts_[call + " " + absl::StatusCodeToString(status.code())];
  if (status.ok() || std::ranges::find(expected, status.code()) != expected.end()) return;
  ++fault_count_;
  if (faults_.size() < kMaxFaults) faults_.push_back(call + ": " + status.ToString());
}

std::map<std::string, long> Tally::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

std::vector<std::string> Tally::faults() const {
  const std::lock_guard lock(mutex_);
  return faults_;
}

long Tally::fault_count() const {
  const std::lock_guard lock(mutex_);
  return fault_count_;
}

}  // namespace motiondb::tests
