// Lets models know new clips within a second, whatever builds are waiting or at work: each stored
// clip asks for it, and one extension takes in all that have come. Thread-safe.
#pragma once

#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "server/engine/live_database.h"
#include "server/engine/workers.h"
#include "storage/motion_store.h"

namespace motiondb::server {

class Extender {
 public:
  // Both must outlive the extender.
  Extender(storage::MotionStore& store, Workers& workers, const EngineOptions& options)
      : store_(store), workers_(workers), options_(options) {}
  ~Extender() { Stop(); }

  // Extends the database's model by the clips there are by now, soon. REQUIRES: within
  // LiveDatabase::WhileAlive.
  void Request(const std::shared_ptr<LiveDatabase>& database);
  // Starts nothing more; returns when nothing runs.
  void Stop();

 private:
  using Clock = std::chrono::steady_clock;

  // A database whose model is being extended, or rests before the next time.
  struct Turn {
    Turn(std::shared_ptr<LiveDatabase> for_database, const Workers::Executor& executor)
        : database(std::move(for_database)), timer(executor) {}
    std::shared_ptr<LiveDatabase> database;
    boost::asio::steady_timer timer;
    bool asked_again = false;
  };

  void Arm(Turn& turn, Clock::duration rest);  // with mutex_ held
  void Run(const std::string& database);

  storage::MotionStore& store_;
  Workers& workers_;
  const EngineOptions options_;

  std::mutex mutex_;
  std::condition_variable none_runs_;
  std::map<std::string, Turn> turns_;
  int running_ = 0;
  bool stopped_ = false;
};

}  // namespace motiondb::server
