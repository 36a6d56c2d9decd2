// The one budget for memory of calls: requests as they were read, files on their way in, motion,
// states and intermediate arrays of queries, and responses on their way out. A call reserves what
// it may allocate before it allocates it. Thread-safe; outlives its reservations.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "storage/mutex.h"

namespace motiondb::server {

// As messages show it.
inline double Mebibytes(std::int64_t bytes) { return static_cast<double>(bytes) / (1 << 20); }

class CallMemory {
 public:
  // Memory of one call and client; released when it is destroyed. Used by one thread at a time.
  class Reservation {
   public:
    // `client`: as CallLimits has it, a principal or the source of an address.
    Reservation(CallMemory& memory, std::string client)
        : memory_(memory), client_(std::move(client)) {}
    Reservation(const Reservation&) = delete;
    Reservation& operator=(const Reservation&) = delete;
    ~Reservation();

    // Reserves `bytes` in place of what was reserved before. RESOURCE_EXHAUSTED, with the former
    // reservation kept, if they do not fit; the error says whether a retry can succeed.
    absl::Status Resize(std::int64_t bytes);
    // Later reservations count for another client; the present one moves to it.
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
  // Under the mutex.
  void Add(const std::string& client, std::int64_t bytes) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::int64_t limit_;
  const std::int64_t client_limit_;
  mutable storage::Mutex mutex_;
  std::int64_t reserved_ ABSL_GUARDED_BY(mutex_) = 0;
  std::map<std::string, std::int64_t> per_client_
      ABSL_GUARDED_BY(mutex_);  // of clients with a reservation
};

// What one call may reserve, by its size: the decompressed bytes that it sends and the stored bytes
// that it names. Less than the promised 64 MB and ten times the size, since an allocator takes some
// percent more than it is asked for.
std::int64_t MostOfOneCall(std::int64_t size_bytes);

}  // namespace motiondb::server
