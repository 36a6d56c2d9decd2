// Looks after files that an operator may replace while the server runs: reads them again and again;
// what cannot be used is logged, once, and what was read before stays in force. Thread-safe.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "absl/status/statusor.h"

namespace motiondb::server {

class FileWatch {
 public:
  // Reads the files and puts what they hold in force: true if it is something new. Called on a
  // thread of the watch's own, until that is destroyed. Its errors must not hold what is secret.
  using Take = std::function<absl::StatusOr<bool>()>;

  // `what` is read from `file`, for the log: "certificates".
  FileWatch(std::string what, std::string file, Take take,
            std::chrono::milliseconds period = std::chrono::seconds(1));
  ~FileWatch();
  FileWatch(const FileWatch&) = delete;
  FileWatch& operator=(const FileWatch&) = delete;

 private:
  void Watch();
  void Look();

  const std::string what_;
  const std::string file_;
  const Take take_;
  const std::chrono::milliseconds period_;
  std::string fault_;  // of the files as they are now, already logged

  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace motiondb::server
