#include "server/engine/work/work_options.h"

#include "absl/strings/cord.h"

namespace motiondb::server {
namespace {

constexpr char kHeavyWorkMark[] = "motiondb.heavy-work";
constexpr char kAwaitsChangeMark[] = "motiondb.awaits-change";

}  // namespace

absl::Status HeavyWork() {
  absl::Status status = absl::ResourceExhaustedError("heavy work is not allowed here");
  status.SetPayload(kHeavyWorkMark, absl::Cord());
  return status;
}

bool IsHeavyWork(const absl::Status& status) {
  return status.GetPayload(kHeavyWorkMark).has_value();
}

absl::Status AwaitsChange() {
  absl::Status status = absl::UnavailableError("the work waits for a change");
  status.SetPayload(kAwaitsChangeMark, absl::Cord());
  return status;
}

bool IsAwaitingChange(const absl::Status& status) {
  return status.GetPayload(kAwaitsChangeMark).has_value();
}

}  // namespace motiondb::server
