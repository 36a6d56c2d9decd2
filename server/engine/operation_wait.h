// Waiting for an operation without holding a thread.
#pragma once

#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "server/engine/operation_book.h"
#include "server/engine/workers.h"

namespace motiondb::server {

// Thread-safe. Keeps itself alive until it has ended; the book must outlive it.
class OperationWait : public std::enable_shared_from_this<OperationWait> {
 public:
  using Done = std::function<void(absl::StatusOr<storage::OperationRecord>)>;

  // Calls `done` once, on one of the executor's threads, with the operation as it stands when it is
  // done, the timeout has passed or Stop was called. NOT_FOUND if there is no such operation.
  static std::shared_ptr<OperationWait> Start(const Workers::Executor& executor,
                                              OperationBook& book, std::string id,
                                              std::chrono::steady_clock::duration timeout,
                                              Done done);
  // Ends the wait now.
  void Stop();

 private:
  OperationWait(const Workers::Executor& executor, OperationBook& book, std::string id, Done done);
  void Begin(std::chrono::steady_clock::duration timeout);
  void End(absl::StatusOr<storage::OperationRecord> record);

  // All that follows is touched on the strand alone.
  boost::asio::strand<Workers::Executor> strand_;
  boost::asio::steady_timer timer_;
  OperationBook& book_;
  const std::string id_;
  Done done_;
  std::uint64_t watch_ = 0;
};

}  // namespace motiondb::server
