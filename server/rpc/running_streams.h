// The running Observe streams of the server and their newest answers, for spectators. Thread-safe.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "motiondb/v1/observe.pb.h"
#include "server/engine/change_signal.h"
#include "server/engine/live_database.h"
#include "storage/mutex.h"

namespace motiondb::server {

// A stream. Owned by its registration and by its spectators. Publishing does not wait for
// spectators: each takes the newest answer when its client has accepted the one before.
class RunningStream {
 public:
  // An answer and its number, from 1.
  struct Published {
    std::int64_t number = 0;
    std::shared_ptr<const v1::WatchStreamResponse> answer;
  };

  // `description`: without the frame.
  RunningStream(std::shared_ptr<LiveDatabase> database, v1::ObservedStream description)
      : database_(std::move(database)), description_(std::move(description)) {}

  const std::shared_ptr<LiveDatabase>& database() const { return database_; }
  // With the newest frame.
  v1::ObservedStream Description() const;

  // Counts an answer. Returns its number if it has spectators, who then wait for Publish.
  std::optional<std::int64_t> CountAnswer(std::int64_t frame);
  void Publish(std::int64_t number, v1::WatchStreamResponse answer);
  // No answer follows. `why`: status of the spectators.
  void End(const absl::Status& why);

  // A spectator for its lifetime.
  class Spectator {
   public:
    explicit Spectator(std::shared_ptr<RunningStream> stream);
    ~Spectator();
    Spectator(const Spectator&) = delete;
    Spectator& operator=(const Spectator&) = delete;

    RunningStream& stream() const { return *stream_; }
    // Returns the newest answer since the last call, with the number of answers before it that were
    // left out. Nothing if there is none yet.
    std::optional<v1::WatchStreamResponse> Take();

   private:
    const std::shared_ptr<RunningStream> stream_;
    std::int64_t taken_ = 0;  // number of the last answer
  };

  // Absent while the stream runs.
  std::optional<absl::Status> ended() const;
  // Notified of each published answer and of the end.
  const std::shared_ptr<ChangeSignal>& signal() const { return signal_; }

 private:
  const std::shared_ptr<LiveDatabase> database_;
  const v1::ObservedStream description_;
  const std::shared_ptr<ChangeSignal> signal_ = std::make_shared<ChangeSignal>();

  mutable storage::Mutex mutex_;
  std::int64_t frame_ ABSL_GUARDED_BY(mutex_) = 0;
  std::int64_t answers_ ABSL_GUARDED_BY(mutex_) = 0;
  int spectators_ ABSL_GUARDED_BY(mutex_) = 0;
  Published newest_ ABSL_GUARDED_BY(mutex_);
  std::optional<absl::Status> ended_ ABSL_GUARDED_BY(mutex_);
};

class RunningStreams {
 public:
  // `server`: name of the server, the first part of the ids; empty: the ids are numbers.
  explicit RunningStreams(const std::string& server = "")
      : prefix_(server.empty() ? "" : server + "-") {}

  // A stream in the registry for its lifetime.
  class Registration {
   public:
    Registration(RunningStreams& streams, std::uint64_t key, std::shared_ptr<RunningStream> stream)
        : streams_(streams), key_(key), stream_(std::move(stream)) {}
    ~Registration() { streams_.Remove(key_); }
    Registration(const Registration&) = delete;
    Registration& operator=(const Registration&) = delete;

    RunningStream& stream() const { return *stream_; }

   private:
    RunningStreams& streams_;
    const std::uint64_t key_;
    const std::shared_ptr<RunningStream> stream_;
  };

  // Adds a stream. Sets the name in its description.
  std::unique_ptr<Registration> Add(std::shared_ptr<LiveDatabase> database,
                                    v1::ObservedStream description);
  // Returns the streams of a database, oldest first; at most `limit`. O(streams of the server).
  std::vector<std::shared_ptr<RunningStream>> List(const LiveDatabase& database, int limit) const;
  // NOT_FOUND.
  absl::StatusOr<std::shared_ptr<RunningStream>> Find(const LiveDatabase& database,
                                                      const std::string& id) const;

 private:
  void Remove(std::uint64_t key);

  const std::string prefix_;
  mutable storage::Mutex mutex_;
  std::map<std::uint64_t, std::shared_ptr<RunningStream>> streams_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t last_key_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace motiondb::server
