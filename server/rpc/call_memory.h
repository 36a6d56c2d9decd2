// Memory budget of all calls: parsed requests, uploaded files, motion, states and intermediate
// arrays of queries, and responses until they are sent. A call reserves memory before it allocates
// it. Thread-safe; outlives its reservations.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "storage/mutex.h"

namespace motiondb::server {

// For error messages.
inline double Mebibytes(std::int64_t bytes) { return static_cast<double>(bytes) / (1 << 20); }

class CallMemory {
 public:
  // Memory of one call and client. The destructor releases it. Used by one thread at a time.
  class Reservation {
   public:
    // `client`: key as in CallLimits, a principal or the source of an address.
    Reservation(CallMemory& memory, std::string client)
        : memory_(memory), client_(std::move(client)) {}
    Reservation(const Reservation&) = delete;
    Reservation& operator=(const Reservation&) = delete;
    ~Reservation();

    // Changes the reservation to `bytes`. RESOURCE_EXHAUSTED at a limit; then the reservation is
    // unchanged, and the error states whether a retry can succeed.
    absl::Status Resize(std::int64_t bytes);
    // Moves this and later reservations to another client.
    void SetClient(const std::string& client);

    std::int64_t bytes() const { return bytes_; }

   private:
    CallMemory& memory_;
    std::string client_;
    std::int64_t bytes_ = 0;
  };

  // A client may reserve half of `limit`.
  explicit CallMemory(std::int64_t limit) : limit_(limit), client_limit_(limit / 2) {}

  std::int64_t reserved() const;

 private:
  absl::Status Change(const std::string& client, std::int64_t from, std::int64_t to);
  void Add(const std::string& client, std::int64_t bytes) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::int64_t limit_;
  const std::int64_t client_limit_;
  mutable storage::Mutex mutex_;
  std::int64_t reserved_ ABSL_GUARDED_BY(mutex_) = 0;
  std::map<std::string, std::int64_t> per_client_
      ABSL_GUARDED_BY(mutex_);  // only clients with reservations
};

// Returns the memory that one call may reserve, in bytes. `size_bytes`: decompressed bytes that it
// sends and stored bytes that it names. It is less than the documented 64 MB plus ten times the
// size, because an allocator needs a few percent more.
std::int64_t MaxCallMemory(std::int64_t size_bytes);

}  // namespace motiondb::server
