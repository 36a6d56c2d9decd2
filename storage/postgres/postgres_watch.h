// Notifications of changes: a session that listens to the channel on which the triggers of the
// tables (migrations.cc) notify. Only without a pooler.
#pragma once

#include <memory>
#include <string_view>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/motion_store.h"
#include "storage/postgres/postgres_connector.h"

namespace motiondb::storage {

// The session. Only one thread at a time may use it.
class PostgresListener {
 public:
  explicit PostgresListener(std::shared_ptr<PostgresConnector> connector)
      : connector_(std::move(connector)) {}

  // Opens a session if there is none. What changed before is not notified. The errors of
  // PostgresConnector; UNAVAILABLE.
  absl::Status Connect();
  // Becomes readable when Poll has something to read; -1 if there is no session.
  int socket() const { return session_ == nullptr ? -1 : PQsocket(session_.get()); }
  // Returns the changes that have arrived, without waiting. UNAVAILABLE if the session was lost.
  absl::StatusOr<std::vector<StoreChange>> Poll();

 private:
  const std::shared_ptr<PostgresConnector> connector_;
  SessionHandle session_;
};

// Calls `on_change` on a thread of its own. Connects again after a loss, and then notifies that
// anything may have changed.
class PostgresWatch final : public StoreWatch {
 public:
  // Null if there is no memory for a thread, or no file descriptor.
  static std::unique_ptr<StoreWatch> Start(const PostgresAddress& address, OnStoreChange on_change);
  ~PostgresWatch() override;

 private:
  PostgresWatch(const PostgresAddress& address, OnStoreChange on_change);
  void Run();
  // Waits until there is something to read from the listener or the watch ends, but at most as long
  // as given. Returns false if the watch ends.
  bool Wait(int milliseconds);

  PostgresListener listener_;
  const OnStoreChange on_change_;
  const int end_;  // an eventfd, readable when the watch ends
  std::thread thread_;
};

}  // namespace motiondb::storage
