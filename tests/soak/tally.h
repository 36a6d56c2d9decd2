// Counts the calls of a soak by kind and code, and collects faults. Thread-safe.
#pragma once

#include <initializer_list>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace motiondb::tests {

class Tally {
 public:
  // Counts one call. OK is never a fault; `expected` are codes caused by the client.
  void Add(const std::string& call, const absl::Status& status,
           std::initializer_list<absl::StatusCode> expected = {});

  // Returns the number of calls by kind and code: "Recognize OK" -> 812.
  std::map<std::string, long> counts() const;
  // Returns the first faults, at most 20, and their total number.
  std::vector<std::string> faults() const;
  long fault_count() const;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, long> counts_;
  std::vector<std::string> faults_;
  long fault_count_ = 0;
};

}  // namespace motiondb::tests
