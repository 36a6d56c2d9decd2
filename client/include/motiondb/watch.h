// motiondb::client::Watch: the changes of a database, as they happen, also across restarts of the
// server. Client::WatchDatabase opens it.
//
// Thread-safety: one thread calls Next; Cancel may be called from any thread.
// Ownership: a watch shares the connection of its client and may outlive the client. The destructor
// cancels a watch that has not ended.
#pragma once

#include <motiondb/messages.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>

#include "absl/status/status.h"

namespace motiondb::client {

struct WatchOptions {
  // Called before each attempt to reconnect, with the error and the time until the attempt. May be
  // null.
  std::function<void(const absl::Status& error, std::chrono::milliseconds delay)> on_reconnect;
};

class Watch {
 public:
  Watch(Watch&&) noexcept;
  Watch& operator=(Watch&&) noexcept;
  ~Watch();

  // Waits for the next message. Returns false if the watch has ended; Finish returns why. If the
  // server becomes unavailable, Next connects again: immediately to each other address of the
  // client, then after 0.2 s, then twice as long each time, at most 10 s. Each change is returned
  // exactly once, also if a connection ended in the middle of a transaction. A message that only
  // reports `up_to_date` can be repeated.
  bool Next(v1::WatchDatabaseResponse& message);

  // Revision of the last transaction that Next has returned completely; at the beginning,
  // after_revision of the request. A later watch after it misses nothing.
  std::int64_t revision() const;

  // Returns why Next returned false: CANCELLED after Cancel; NOT_FOUND: the database was deleted;
  // OUT_OF_RANGE: deletions since the revision are no longer known, so start again from 0; or
  // another error that a new connection does not fix.
  absl::Status Finish() const;

  // Ends the watch immediately, also while Next waits.
  void Cancel();

 private:
  friend class Client;
  class Stream;
  explicit Watch(std::unique_ptr<Stream> stream);

  std::unique_ptr<Stream> stream_;
};

}  // namespace motiondb::client
