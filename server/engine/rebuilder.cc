#include "server/engine/rebuilder.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <exception>
#include <new>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "core/motion/error.h"
#include "core/tree/divide_node.h"
#include "server/engine/memory_reserve.h"
#include "storage/cancellable_lock.h"

namespace motiondb::server {
namespace {

// A tree of one node answers as if all motion were the same, and no call fails of it.
void WarnOfSingleNode(const LiveDatabase& database) {
  const std::shared_ptr<const Snapshot> current = database.snapshot();
  if (current == nullptr) return;
  const core::Model& model = current->model;
  if (!core::IsUndivided(model.tree(), model.settings().min_frames)) return;
  spdlog::warn(
      "database '{}': the tree of model {} is a single node of {} frames, which tells no motion "
      "from another: its frames are all alike, or some of its clips have frames far from all "
      "others; look for glitches in the clips that were ingested last",
      database.name(), current->record.version, model.frame_count());
}

}  // namespace

absl::StatusOr<storage::OperationRecord> Rebuilder::Request(
    const std::shared_ptr<LiveDatabase>& database, const core::Cancelled& cancelled) {
  auto operation = RequestInTurn(database, cancelled);
  // The change that asks for it was made all the same.
  if (absl::IsCancelled(operation.status())) {
    boost::asio::post(workers_.build_executor(), [this, database] { RequestForNobody(database); });
  }
  return operation;
}

void Rebuilder::RequestForNobody(const std::shared_ptr<LiveDatabase>& database) {
  database->WhileAlive(Retiring::kAwait, [&] { return Request(database).status(); })
      .IgnoreError();  // where the database was deleted, so was what is to be rebuilt
}

absl::StatusOr<storage::OperationRecord> Rebuilder::RequestInTurn(
    const std::shared_ptr<LiveDatabase>& database, const core::Cancelled& cancelled) {
  if (auto joined = Join(database)) return *std::move(joined);
  std::unique_lock turn(waiting_mutex_, std::defer_lock);
  MOTIONDB_RETURN_IF_ERROR(storage::Lock(turn, cancelled));
  if (auto joined = Join(database)) return *std::move(joined);
  MOTIONDB_ASSIGN_OR_RETURN(auto operation, book_.Create(database->name(), cancelled));
  const std::lock_guard lock(mutex_);
  Queue& queue = QueueOf(database);
  queue.first_asked = queue.last_asked = Clock::now();
  queue.waiting.push_back(operation.id);
  queue.retry.cancel();
  Arm(queue);
  return operation;
}

std::optional<storage::OperationRecord> Rebuilder::Join(
    const std::shared_ptr<LiveDatabase>& database) {
  const std::lock_guard lock(mutex_);
  Queue& queue = QueueOf(database);
  if (queue.waiting.empty() || queue.waiting.back() == queue.held_back) return std::nullopt;
  auto operation = book_.Get(queue.waiting.back());
  if (!operation.ok()) return std::nullopt;
  queue.last_asked = Clock::now();
  Arm(queue);
  return *std::move(operation);
}

void Rebuilder::Resume(const std::shared_ptr<LiveDatabase>& database,
                       const std::string& operation) {
  const std::lock_guard lock(mutex_);
  Queue& queue = QueueOf(database);
  queue.waiting.push_back(operation);
  queue.first_asked = queue.last_asked = Clock::now();
  Arm(queue);
}

Rebuilder::Ingest::Ingest(Rebuilder& rebuilder, std::shared_ptr<LiveDatabase> database)
    : rebuilder_(rebuilder), database_(std::move(database)) {
  const std::lock_guard lock(rebuilder_.mutex_);
  Queue& queue = rebuilder_.QueueOf(database_);
  ++queue.ingests;
  rebuilder_.Arm(queue);
}

Rebuilder::Ingest::~Ingest() {
  const std::lock_guard lock(rebuilder_.mutex_);
  Queue* const queue = rebuilder_.FindQueue(*database_);
  if (queue == nullptr) return;
  --queue->ingests;
  queue->last_asked = Clock::now();
  rebuilder_.Arm(*queue);
}

absl::StatusOr<bool> Rebuilder::Cancel(const LiveDatabase& database, const std::string& operation,
                                       const core::Cancelled& cancelled) {
  bool is_stopped = false;  // a waiting one may begin at any moment
  const auto stop_or_give_up = [&] {
    is_stopped = StopRunning(database, operation);
    return is_stopped || (cancelled && cancelled());
  };
  std::unique_lock turn(waiting_mutex_, std::defer_lock);
  const absl::Status locked = storage::Lock(turn, stop_or_give_up);
  if (is_stopped) return true;
  MOTIONDB_RETURN_IF_ERROR(locked);
  if (!HoldBack(database, operation)) return StopRunning(database, operation);
  bool is_stored = false;
  const absl::Cleanup end = [&] {
    const std::lock_guard lock(mutex_);
    Queue* const queue = FindQueue(database);
    if (is_stored) std::erase(queue->waiting, operation);
    queue->held_back.clear();
    Arm(*queue);
  };
  MOTIONDB_RETURN_IF_ERROR(book_.Cancel(operation, cancelled));
  return is_stored = true;
}

bool Rebuilder::HoldBack(const LiveDatabase& database, const std::string& operation) {
  const std::lock_guard lock(mutex_);
  Queue* const queue = FindQueue(database);
  if (queue == nullptr || !std::ranges::count(queue->waiting, operation)) return false;
  queue->held_back = operation;
  return true;
}

bool Rebuilder::StopRunning(const LiveDatabase& database, const std::string& operation) {
  const std::lock_guard lock(mutex_);
  Queue* const queue = FindQueue(database);
  if (queue == nullptr || queue->running == nullptr || queue->running->operation != operation) {
    return false;
  }
  StopReason none = StopReason::kNone;
  return queue->running->stop.compare_exchange_strong(none, StopReason::kCancelled);
}

void Rebuilder::Forget(const LiveDatabase& database) {
  const std::lock_guard lock(mutex_);
  Queue* const queue = FindQueue(database);
  if (queue == nullptr) return;
  for (const std::string& operation : queue->waiting) book_.Abandon(operation);
  if (queue->running != nullptr) queue->running->stop = StopReason::kForgotten;
  queue->database->set_operation("");
  queues_.erase(database.name());
}

void Rebuilder::Stop() {
  std::unique_lock lock(mutex_);
  stopped_ = true;
  for (auto& [name, queue] : queues_) {
    queue.timer.cancel();
    queue.retry.cancel();
    if (queue.running == nullptr) continue;
    StopReason none = StopReason::kNone;
    queue.running->stop.compare_exchange_strong(none, StopReason::kShutdown);
  }
  none_runs_.wait(lock, [this] { return running_ == 0; });
}

Rebuilder::Queue& Rebuilder::QueueOf(const std::shared_ptr<LiveDatabase>& database) {
  const auto [entry, added] =
      queues_.try_emplace(database->name(), database, workers_.build_executor());
  return entry->second;
}

Rebuilder::Queue* Rebuilder::FindQueue(const LiveDatabase& database) {
  const auto found = queues_.find(database.name());
  const bool same = found != queues_.end() && found->second.database.get() == &database;
  return same ? &found->second : nullptr;
}

Rebuilder::Clock::time_point Rebuilder::DueTime(const Queue& queue) const {
  const Clock::time_point latest = queue.first_asked + options_.rebuild_delay_limit;
  if (queue.ingests > 0) return latest;
  return std::min(latest, queue.last_asked + options_.rebuild_delay);
}

void Rebuilder::Arm(Queue& queue) {
  queue.database->set_operation(queue.running != nullptr ? queue.running->operation
                                : queue.waiting.empty()  ? ""
                                                         : queue.waiting.front());
  if (stopped_ || queue.running != nullptr || queue.waiting.empty()) return;
  queue.timer.expires_at(DueTime(queue));
  queue.timer.async_wait(
      [this, name = queue.database->name()](const boost::system::error_code& error) {
        if (!error) OnTimer(name);
      });
}

void Rebuilder::RetryLater(Queue& queue) {
  if (stopped_ || !queue.waiting.empty()) return;
  queue.retry.expires_after(options_.rebuild_retry_delay);
  queue.retry.async_wait([this, database = queue.database](const boost::system::error_code& error) {
    if (!error) RequestForNobody(database);
  });
}

std::shared_ptr<Rebuilder::Build> Rebuilder::TakeDue(const std::string& database) {
  const auto found = queues_.find(database);
  if (stopped_ || found == queues_.end()) return nullptr;
  Queue& queue = found->second;
  if (queue.running != nullptr || queue.waiting.empty()) return nullptr;
  if (queue.waiting.front() == queue.held_back) return nullptr;
  if (Clock::now() < DueTime(queue)) return nullptr;  // the timer was set anew since
  queue.running = std::make_shared<Build>();
  queue.running->operation = std::move(queue.waiting.front());
  queue.running->database = queue.database;
  queue.waiting.pop_front();
  Arm(queue);
  return queue.running;
}

void Rebuilder::OnTimer(const std::string& database) {
  std::shared_ptr<Build> build;
  {
    const std::lock_guard lock(mutex_);
    build = TakeDue(database);
    if (build == nullptr) return;
    ++running_;
  }
  Run(*build);
  Finish(build);
}

void Rebuilder::Run(Build& build) {
  const auto stopped = [&] { return build.stop != StopReason::kNone; };
  const auto progress = [&](double fraction, std::string_view stage) {
    book_.Advance(build.operation, fraction, stage);
    return !stopped();
  };
  // Nothing is stored of an operation once its database is gone: another may have its name.
  const auto while_alive = [&](const std::function<void()>& store) {
    return build.database->WhileAlive(Retiring::kAwait, [&] {
      store();
      return absl::OkStatus();
    });
  };
  const Clock::time_point began = Clock::now();
  absl::StatusOr<Rebuilt> rebuilt;
  while_alive([&] { book_.Start(build.operation); }).IgnoreError();  // it finds out itself
  try {
    const AllocationsMayFail scope;
    rebuilt =
        Rebuild(store_, *build.database, options_, workers_.build_parallel(), progress, stopped);
  } catch (const std::bad_alloc&) {
    rebuilt = absl::ResourceExhaustedError("not enough memory to build the model");
  } catch (const std::exception& error) {
    rebuilt = absl::InternalError(error.what());
  }
  const std::chrono::duration<double> took = Clock::now() - began;
  const auto outcome = rebuilt.ok()                      ? &RebuildTally::succeeded
                       : build.stop != StopReason::kNone ? &RebuildTally::cancelled
                                                         : &RebuildTally::failed;
  build.wants_retry =
      outcome == &RebuildTally::failed &&
      (absl::IsResourceExhausted(rebuilt.status()) || absl::IsUnavailable(rebuilt.status()));
  // Before the operation ends, so that who waited for it finds it counted.
  build.database->CountRebuild(outcome, took.count());
  const absl::Status ended = while_alive([&] { StoreEnd(build, rebuilt); });
  if (!ended.ok()) book_.Abandon(build.operation);
}

void Rebuilder::StoreEnd(const Build& build, const absl::StatusOr<Rebuilt>& rebuilt) {
  const std::string& name = build.database->name();
  if (rebuilt.ok()) {
    WarnOfSingleNode(*build.database);
    book_.Succeed(build.operation, rebuilt->version, rebuilt->difference);
    spdlog::info("database '{}': model {} is current{}{}", name, rebuilt->version,
                 rebuilt->difference.empty() ? "" : ", ", rebuilt->difference);
    return;
  }
  switch (build.stop) {
    case StopReason::kForgotten:  // with its database
      return book_.Abandon(build.operation);
    case StopReason::kShutdown:
      return book_.Postpone(build.operation);
    case StopReason::kCancelled:
      spdlog::info("database '{}': the rebuild was cancelled", name);
      return book_.Cancel(build.operation).IgnoreError();
    case StopReason::kNone:
      if (absl::IsNotFound(rebuilt.status())) return book_.Abandon(build.operation);
      // What was deleted again and again is the clients' doing; each deletion asks for a rebuild.
      spdlog::log(absl::IsAborted(rebuilt.status()) ? spdlog::level::warn : spdlog::level::err,
                  "database '{}': the rebuild failed: {}", name, rebuilt.status().ToString());
      return book_.Fail(build.operation, rebuilt.status());
  }
}

void Rebuilder::Finish(const std::shared_ptr<Build>& build) {
  const std::lock_guard lock(mutex_);
  if (Queue* const queue = FindQueue(*build->database)) {
    queue->running = nullptr;
    Arm(*queue);
    if (build->wants_retry) RetryLater(*queue);
  }
  if (--running_ == 0) none_runs_.notify_all();
}

}  // namespace motiondb::server
