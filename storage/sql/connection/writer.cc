#include "storage/sql/connection/writer.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/motion/error.h"
#include "storage/cancellable_lock.h"
#include "storage/thread_scopes.h"

namespace motiondb::storage {
namespace {

// Maximum number of pieces of ordinary work that begin while background work waits.
constexpr int kMaxPassedOver = 4;
// Limits of a shared transaction, so that urgent work does not wait longer for it than for others.
// With four clients, sharing adds 653 clips a second; without it, 547.
constexpr std::size_t kMaxShared = 32;
constexpr std::int64_t kMaxSharedBytes = 4 << 20;

}  // namespace

Writer::Writer(std::unique_ptr<Connection> connection) : connection_(std::move(connection)) {
  taken_.reserve(kMaxShared);
  thread_ = std::thread([this] { Serve(); });
}

Writer::~Writer() {
  {
    const MutexLock lock(mutex_);
    is_closing_ = true;
    changed_.NotifyAll();
    changed_.Wait(mutex_, [this] {
      mutex_.AssertHeld();
      return callers_ == 0;
    });
  }
  thread_.join();
}

absl::Status Writer::Submit(Priority priority, const core::Cancelled& cancelled, const Piece& piece,
                            const Share* share) {
  Request request{.piece = &piece, .share = share, .may_fail = AllocationsMayFail::hold()};
  const MutexLock lock(mutex_);
  Queue& queue = queues_[static_cast<std::size_t>(priority)];
  queue.push_back(&request);
  ++callers_;
  changed_.NotifyAll();
  const bool has_begun = request.is_over.WaitOrCancel(
      mutex_, cancelled, [&] { return request.state != Request::State::kQueued; });
  if (has_begun) {
    request.is_over.Wait(mutex_, [&] { return request.state == Request::State::kOver; });
  } else {
    std::erase(queue, &request);
  }
  --callers_;
  if (is_closing_) changed_.NotifyAll();
  if (request.thrown) std::rethrow_exception(request.thrown);
  return has_begun ? absl::OkStatus() : CancelledInQueue();
}

void Writer::Serve() {
  while (true) {
    const std::vector<Request*>& requests = Next();
    if (requests.empty()) return;
    if (requests.size() == 1 || !RunTogether(requests)) {
      for (Request* const request : requests) RunAlone(*request);
    }
    const MutexLock lock(mutex_);
    for (Request* const request : requests) {
      request->state = Request::State::kOver;
      request->is_over.NotifyOne();  // under the mutex: the caller destroys the request afterwards
    }
  }
}

void Writer::RunAlone(Request& request) {
  // The same scope as on the waiting thread, which rethrows the exception.
  std::optional<AllocationsMayFail> scope;
  if (request.may_fail) scope.emplace();
  try {
    (*request.piece)(*connection_);
  } catch (...) {
    request.thrown = std::current_exception();
  }
}

bool Writer::RunTogether(const std::vector<Request*>& requests) {
  std::int64_t added_bytes = 0;
  for (const Request* const request : requests) added_bytes += request->share->added_bytes;
  const auto all = [&](Connection& connection) -> absl::Status {
    for (const Request* const request : requests) {
      MOTIONDB_RETURN_IF_ERROR(request->share->body(connection));
    }
    return absl::OkStatus();
  };
  const AllocationsMayFail scope;
  try {
    const absl::Status done = requests.front()->share->transact(*connection_, added_bytes, all);
    if (!absl::IsUnavailable(done)) return done.ok();
    // After a lost COMMIT, a request that runs again could find its own change.
    for (const Request* const request : requests) request->share->fail(done);
    return true;
  } catch (const std::exception&) {
    return false;  // each request then runs alone and gets its own exception
  }
}

const std::vector<Writer::Request*>& Writer::Next() {
  const MutexLock lock(mutex_);
  changed_.Wait(mutex_, [this] {
    mutex_.AssertHeld();
    return is_closing_ || std::ranges::any_of(queues_, [](auto& queue) { return !queue.empty(); });
  });
  taken_.clear();
  Queue* const queue = NextQueue();
  if (queue == nullptr) return taken_;
  std::int64_t bytes = 0;
  do {
    Request* const request = queue->front();
    queue->pop_front();
    request->state = Request::State::kRunning;
    taken_.push_back(request);
    if (request->share == nullptr) break;
    bytes += request->share->added_bytes;
  } while (taken_.size() < kMaxShared && !queue->empty() && queue->front()->share != nullptr &&
           bytes + queue->front()->share->added_bytes <= kMaxSharedBytes);
  return taken_;
}

Writer::Queue* Writer::NextQueue() {
  auto& [urgent, ordinary, background] = queues_;
  if (!urgent.empty()) return &urgent;
  if (!ordinary.empty() && (background.empty() || passed_over_ < kMaxPassedOver)) {
    passed_over_ = background.empty() ? 0 : passed_over_ + 1;
    return &ordinary;
  }
  passed_over_ = 0;
  return background.empty() ? nullptr : &background;
}

}  // namespace motiondb::storage
