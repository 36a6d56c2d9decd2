// What a ModelLifecycle does on the threads for builds and extensions.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <new>

#include "core/tree/divide_node.h"
#include "server/engine/extend.h"
#include "server/engine/memory_reserve.h"
#include "server/engine/model_lifecycle.h"
#include "server/engine/snapshot.h"

namespace motiondb::server {
namespace {

using std::chrono::milliseconds;
using storage::MutexLock;

// A burst of clips takes this share of a thread at most: an extension's rest is so many times its
// work.
constexpr int kRest = 3;
constexpr milliseconds kLeastRest{50};
constexpr milliseconds kLongestRest{500};  // so that a clip is known within a second

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

void ModelLifecycle::BeginIfDue() {
  std::shared_ptr<Build> build;
  {
    const MutexLock lock(mutex_);
    // The timer may have been about to fire when it was set anew.
    if (state() != State::kWaiting || services_.executor.Now() < DueTime()) return;
    build = running_ = std::make_shared<Build>();
    build->operation = std::move(waiting_.front());
    waiting_.pop_front();
    Arm();
  }
  End(Run(*build));
}

absl::StatusOr<Rebuilt> ModelLifecycle::Run(Build& build) {
  OperationBook& operations = services_.operations;
  const auto stopped = [&] { return build.stop != StopReason::kNone; };
  const auto progress = [&](double fraction, std::string_view stage) {
    operations.Advance(build.operation, fraction, stage);
    return !stopped();
  };
  // Nothing is stored of an operation once its database is gone: another may have its name.
  const auto while_alive = [&](const std::function<void()>& store) {
    return database_.WhileAlive(Retiring::kAwait, [&] {
      store();
      return absl::OkStatus();
    });
  };
  const auto began = services_.executor.Now();
  absl::StatusOr<Rebuilt> rebuilt;
  while_alive([&] { operations.Start(build.operation); }).IgnoreError();  // it finds out itself
  try {
    const AllocationsMayFail scope;
    rebuilt = Rebuild(services_.store, database_, services_.options,
                      services_.executor.Parallel(Pool::kBuilds), progress, stopped);
  } catch (const std::bad_alloc&) {
    rebuilt = absl::ResourceExhaustedError("not enough memory to build the model");
  } catch (const std::exception& error) {
    rebuilt = absl::InternalError(error.what());
  }
  const std::chrono::duration<double> took = services_.executor.Now() - began;
  // Before the operation ends, so that who waited for it finds it counted.
  database_.CountRebuild(rebuilt.ok() ? &RebuildTally::succeeded
                         : stopped()  ? &RebuildTally::cancelled
                                      : &RebuildTally::failed,
                         took.count());
  const absl::Status ended = while_alive([&] { StoreEnd(build, rebuilt); });
  if (!ended.ok()) operations.Abandon(build.operation);
  return rebuilt;
}

void ModelLifecycle::StoreEnd(const Build& build, const absl::StatusOr<Rebuilt>& rebuilt) {
  OperationBook& operations = services_.operations;
  const std::string& name = database_.name();
  if (rebuilt.ok()) {
    WarnOfSingleNode(database_);
    operations.Succeed(build.operation, rebuilt->version, rebuilt->difference);
    spdlog::info("database '{}': model {} is current{}{}", name, rebuilt->version,
                 rebuilt->difference.empty() ? "" : ", ", rebuilt->difference);
    return;
  }
  switch (build.stop) {
    case StopReason::kForgotten:  // with its database
      return operations.Abandon(build.operation);
    case StopReason::kShutdown:
      return operations.Postpone(build.operation);
    case StopReason::kCancelled:
      spdlog::info("database '{}': the rebuild was cancelled", name);
      return operations.Cancel(build.operation).IgnoreError();
    case StopReason::kNone:
      if (absl::IsNotFound(rebuilt.status())) return operations.Abandon(build.operation);
      // What was deleted again and again is the clients' doing; each deletion asks for a rebuild.
      spdlog::log(absl::IsAborted(rebuilt.status()) ? spdlog::level::warn : spdlog::level::err,
                  "database '{}': the rebuild failed: {}", name, rebuilt.status().ToString());
      return operations.Fail(build.operation, rebuilt.status());
  }
}

void ModelLifecycle::End(const absl::StatusOr<Rebuilt>& rebuilt) {
  const MutexLock lock(mutex_);
  const bool lacked_room =
      running_->stop == StopReason::kNone &&
      (absl::IsResourceExhausted(rebuilt.status()) || absl::IsUnavailable(rebuilt.status()));
  running_ = nullptr;
  Arm();
  if (lacked_room && state() == State::kIdle) {
    retry_->Set(services_.executor.Now() + services_.options.rebuild_retry_delay,
                Alive(&ModelLifecycle::RequestInBackground));
  }
  changed_.NotifyAll();
}

void ModelLifecycle::RequestExtension() {
  const MutexLock lock(mutex_);
  if (is_closed_ || extension_waits_) return;
  extension_waits_ = true;
  if (!is_extending_) ArmExtension(Executor::Clock::duration::zero());
}

void ModelLifecycle::ArmExtension(Executor::Clock::duration rest) {
  extension_due_->Set(services_.executor.Now() + rest, Alive(&ModelLifecycle::RunExtension));
}

void ModelLifecycle::RunExtension() {
  {
    const MutexLock lock(mutex_);
    if (is_closed_) return;
    extension_waits_ = false;
    is_extending_ = true;
  }
  const auto began = services_.executor.Now();
  absl::Status status;
  try {
    const AllocationsMayFail scope;
    status = Extend(services_.store, database_, services_.options, core::Serially);
  } catch (const std::exception& error) {
    status = absl::ResourceExhaustedError(error.what());
  }
  if (!status.ok() && !absl::IsNotFound(status)) {
    spdlog::error("database '{}': new clips are not known before the next build: {}",
                  database_.name(), status.ToString());
  }
  const MutexLock lock(mutex_);
  is_extending_ = false;
  if (extension_waits_ && !is_closed_) {
    const Executor::Clock::duration rest = kRest * (services_.executor.Now() - began);
    ArmExtension(std::clamp<Executor::Clock::duration>(rest, kLeastRest, kLongestRest));
  }
  changed_.NotifyAll();
}

}  // namespace motiondb::server
