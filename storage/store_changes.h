// Wakes a server soon after another server has changed the store that they share.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace motiondb::storage {

struct StoreChange {
  // The changed database. Empty: something else may have changed (tokens, operations, the list of
  // databases), or notifications were lost.
  std::string database;
  std::int64_t revision = 0;  // of the database, after the change; 0: not known
};

// Runs on a thread of the store: it must return soon, and must not call the store or destroy the
// watch. It must not throw.
using OnStoreChange = std::function<void(const StoreChange&)>;

// As long as it exists, changes are notified. The destructor waits for a running call. Must be
// destroyed before the store.
class StoreWatch {
 public:
  StoreWatch() = default;
  virtual ~StoreWatch() = default;
  StoreWatch(const StoreWatch&) = delete;
  StoreWatch& operator=(const StoreWatch&) = delete;
};

}  // namespace motiondb::storage
