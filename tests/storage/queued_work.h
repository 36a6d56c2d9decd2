// Work that waits in the queue of a writer.
#pragma once

#include <atomic>
#include <functional>
#include <future>
#include <memory>
#include <new>
#include <thread>
#include <utility>

#include "storage/sql/connection/writer.h"
#include "storage/sqlite/sqlite_connection.h"
#include "tests/storage/require_ok.h"

namespace motiondb::tests {

// Returns a writer of an empty database in memory.
inline std::unique_ptr<storage::Writer> MakeWriter() {
  return std::make_unique<storage::Writer>(Require(
      storage::SqliteConnection::Open(":memory:", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, "")));
}

// Work that its own thread submits. The constructor returns when the work is queued.
class QueuedWork {
 public:
  using Work = std::function<absl::Status(storage::Connection&)>;

  QueuedWork(storage::Writer& writer, storage::Priority priority, Work work) {
    std::promise<void> queued;
    thread_ = std::jthread([this, &writer, priority, &queued, work = std::move(work)] {
      // The first call comes when the work is queued.
      const auto cancelled = [&, is_first = true]() mutable {
        if (std::exchange(is_first, false)) queued.set_value();
        return cancelled_.load();
      };
      try {
        status_ = writer.Run(priority, cancelled, work);
      } catch (const std::bad_alloc&) {
        threw_ = true;
      }
    });
    queued.get_future().wait();
  }
  void Cancel() { cancelled_ = true; }
  void Join() { thread_.join(); }
  // Valid after Join.
  const absl::Status& status() const { return status_; }
  bool threw() const { return threw_; }

 private:
  std::atomic<bool> cancelled_ = false;
  absl::Status status_ = absl::UnknownError("the work has not returned");
  bool threw_ = false;
  std::jthread thread_;  // last: it uses the other members
};

// Blocks a writer until Release.
class WriterHolder {
 public:
  explicit WriterHolder(storage::Writer& writer) {
    std::promise<void> begun;
    thread_ = std::jthread([&writer, &begun, release = release_.get_future().share()] {
      const auto hold = [&](storage::Connection&) {
        begun.set_value();
        release.wait();
        return absl::OkStatus();
      };
      writer.Run(storage::Priority::kOrdinary, {}, hold).IgnoreError();
    });
    begun.get_future().wait();
  }
  void Release() { release_.set_value(); }

 private:
  std::promise<void> release_;
  std::jthread thread_;
};

}  // namespace motiondb::tests
