#include "server/security/file_watch.h"

#include <spdlog/spdlog.h>

#include <utility>

namespace motiondb::server {
FileWatch::FileWatch(std::string what, std::string file, Take take,
                     std::chrono::milliseconds period)
    : what_(std::move(what)),
      file_(std::move(file)),
      take_(std::move(take)),
      period_(period),
      thread_([this] { Watch(); }) {}

FileWatch::~FileWatch() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

// The files are small: they are read, rather than asked for their times, which a change within one
// tick of the clock would leave as they were.
void FileWatch::Watch() {
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, period_, [this] { return stopping_; })) Look();
}

void FileWatch::Look() {
  const absl::StatusOr<bool> taken = take_();
  if (taken.ok()) {
    fault_.clear();
    if (*taken) spdlog::info("new {}, from {}", what_, file_);
  } else if (fault_ != taken.status().message()) {
    fault_ = std::string(taken.status().message());
    spdlog::warn("no new {}, what was read before stays in force: {}", what_, fault_);
  }
}

}  // namespace motiondb::server
