#include "server/engine/operation_wait.h"

#include <boost/asio/bind_executor.hpp>
#include <boost/asio/post.hpp>
#include <utility>

namespace motiondb::server {

std::shared_ptr<OperationWait> OperationWait::Start(const Workers::Executor& executor,
                                                    OperationBook& book, std::string id,
                                                    std::chrono::steady_clock::duration timeout,
                                                    Done done) {
  std::shared_ptr<OperationWait> wait(
      new OperationWait(executor, book, std::move(id), std::move(done)));
  boost::asio::post(wait->strand_, [wait, timeout] { wait->Begin(timeout); });
  return wait;
}

OperationWait::OperationWait(const Workers::Executor& executor, OperationBook& book, std::string id,
                             Done done)
    : strand_(executor),
      timer_(executor),
      book_(book),
      id_(std::move(id)),
      done_(std::move(done)) {}

void OperationWait::Stop() {
  boost::asio::post(strand_,
                    [self = shared_from_this()] { self->End(self->book_.Get(self->id_)); });
}

void OperationWait::Begin(std::chrono::steady_clock::duration timeout) {
  if (!done_) return;  // stopped before it began
  // The book holds no reference of its own: a wait that has ended is not kept for its operation.
  watch_ = book_.Watch(id_, [weak = weak_from_this()](const storage::OperationRecord& record) {
    const auto self = weak.lock();
    if (!self) return;
    boost::asio::post(self->strand_, [self, record] { self->End(record); });
  });
  if (watch_ == 0) return End(book_.Get(id_));
  timer_.expires_after(timeout);
  timer_.async_wait(boost::asio::bind_executor(
      strand_, [self = shared_from_this()](const boost::system::error_code& error) {
        if (!error) self->End(self->book_.Get(self->id_));
      }));
}

void OperationWait::End(absl::StatusOr<storage::OperationRecord> record) {
  if (!done_) return;
  book_.Unwatch(id_, watch_);
  timer_.cancel();
  const Done done = std::exchange(done_, nullptr);
  done(std::move(record));
}

}  // namespace motiondb::server
