// Ends connections on which calls are broken off faster than gRPC 1.51 forgets them ("rapid
// reset"). Such a call is over before anything of ours sees it, and no limit counts it, but it
// costs gRPC some 20 KB until that comes to it: under a flood of them, when the flood ends, after
// gigabytes.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>

#include "server/rpc/call_limits.h"

namespace motiondb::server {

class ResetGuard {
 public:
  // While all connections together keep more calls than `most.in_all`, the one that keeps the most
  // ends, unless that is no more than `most.per_client`. Looks ten times a second, on a thread of
  // its own.
  explicit ResetGuard(CallLimit most);
  ~ResetGuard();
  ResetGuard(const ResetGuard&) = delete;
  ResetGuard& operator=(const ResetGuard&) = delete;

 private:
  void Run();
  void Look();

  const CallLimit most_;
  std::int64_t unanswered_calls_;  // when connections were last asked
  bool ended_some_ = false;        // when they were
  std::mutex mutex_;
  std::condition_variable ends_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace motiondb::server
