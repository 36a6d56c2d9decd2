// What the calls of a soak came to, by kind of call and code, and which of it should not have been.
// Thread-safe.
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
  // Counts one call. OK is always right; `expected` are the codes that are the client's own doing.
  void Add(const std::string& call, const absl::Status& status,
           std::initializer_list<absl::StatusCode> expected = {});

  // How often each kind of call ended in each code: "Recognize OK" -> 812.
  std::map<std::string, long> counts() const;
  // The first of what should not have been, at most 20; and how many there were.
  std::vector<std::string> faults() const;
  long fault_count() const;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, long> counts_;
  std::vector<std::string> faults_;
  long fault_count_ = 0;
};

}  // namespace motiondb::tests
