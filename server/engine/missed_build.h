// When a server requests a build that another one has not: it stored a change, and stopped before
// it stored the operation. Not thread-safe.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "server/engine/work/executor.h"
#include "storage/records.h"

namespace motiondb::server {

class MissedBuild {
 public:
  // `spread`: differs between servers, so that one of them is the first.
  explicit MissedBuild(std::chrono::milliseconds spread) : spread_(spread) {}

  // Called at each look at the store. `is_changed`: the database has changed. `is_busy`: an
  // operation of it has not ended, or this server is updating its model. Returns true, once after
  // changes, if it was not busy for some seconds: the caller then checks the model.
  bool IsDue(Executor::Clock::time_point now, bool is_changed, bool is_busy);
  // Returns whether a build may be requested if the model is out of date. `newest`: the last
  // operation of the database; null: none. If it was cancelled or has failed, the next change
  // requests the build.
  bool MayRequest(const storage::OperationRecord* newest, std::int64_t revision);
  // `requested`: whether a build was requested. After UNAVAILABLE the next look checks again. The
  // delay doubles with each request until the model is up to date.
  void Checked(const absl::StatusOr<bool>& requested);

 private:
  static constexpr std::chrono::milliseconds kDelay{3000};
  static constexpr std::chrono::milliseconds kMaxDelay{600'000};

  const std::chrono::milliseconds spread_;
  std::chrono::milliseconds delay_ = kDelay;
  bool is_unchecked_ = false;
  Executor::Clock::time_point due_;
  std::string stopped_operation_;      // cancelled or failed
  std::int64_t stopped_revision_ = 0;  // of the changes that wait because of it
};

}  // namespace motiondb::server
