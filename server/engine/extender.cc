#include "server/engine/extender.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>

#include "server/engine/extend.h"
#include "server/engine/memory_reserve.h"

namespace motiondb::server {
namespace {

using std::chrono::milliseconds;

// A burst of clips takes this share of a thread at most: a turn's rest is so many times its work.
constexpr int kRest = 3;
constexpr milliseconds kLeastRest{50};
constexpr milliseconds kLongestRest{500};  // so that a clip is known within a second

}  // namespace

void Extender::Request(const std::shared_ptr<LiveDatabase>& database) {
  const std::lock_guard lock(mutex_);
  if (stopped_) return;
  const auto [turn, added] =
      turns_.try_emplace(database->name(), database, workers_.extension_executor());
  if (!added && turn->second.database == database) {
    turn->second.asked_again = true;
    return;
  }
  turn->second.database = database;  // a deleted database's name may have come again
  if (added) Arm(turn->second, Clock::duration::zero());
}

void Extender::Arm(Turn& turn, Clock::duration rest) {
  turn.asked_again = false;
  turn.timer.expires_after(rest);
  turn.timer.async_wait(
      [this, name = turn.database->name()](const boost::system::error_code& error) {
        if (!error) Run(name);
      });
}

void Extender::Run(const std::string& database) {
  std::shared_ptr<LiveDatabase> live;
  {
    const std::lock_guard lock(mutex_);
    if (stopped_) return;
    live = turns_.at(database).database;
    ++running_;
  }
  const Clock::time_point began = Clock::now();
  absl::Status status;
  try {
    const AllocationsMayFail scope;
    status = Extend(store_, *live, options_, core::Serially);
  } catch (const std::exception& error) {
    status = absl::ResourceExhaustedError(error.what());
  }
  if (!status.ok() && !absl::IsNotFound(status)) {
    spdlog::error("database '{}': new clips are not known before the next build: {}", database,
                  status.ToString());
  }
  const std::lock_guard lock(mutex_);
  Turn& turn = turns_.at(database);
  if (turn.asked_again || turn.database != live) {
    const Clock::duration rest = kRest * (Clock::now() - began);
    Arm(turn, std::clamp<Clock::duration>(rest, kLeastRest, kLongestRest));
  } else {
    turns_.erase(database);
  }
  if (--running_ == 0) none_runs_.notify_all();
}

void Extender::Stop() {
  std::unique_lock lock(mutex_);
  stopped_ = true;
  for (auto& [name, turn] : turns_) turn.timer.cancel();
  none_runs_.wait(lock, [this] { return running_ == 0; });
}

}  // namespace motiondb::server
