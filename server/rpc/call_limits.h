// Limits of calls: number in flight, duration, metadata and memory.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/security/call_rules.h"
#include "storage/mutex.h"

namespace motiondb::server {

// Minimum rate at which a client must read a response; if it is slower, the call ends.
inline constexpr std::int64_t kMinBytesPerMillisecond = 64;

struct CallLimit {
  int in_all = 0;
  int per_client = 0;
};

struct CallLimitOptions {
  CallLimit calls{4096, 1024};  // all classes together
  CallLimit heavy{256, 64};
  CallLimit streams{1024, 256};
  // Maximum duration of a call, also without a client deadline. Not for streams of frames, for
  // waits for an operation, which have their own timeout, and for maintenance.
  std::chrono::milliseconds max_call_time{600'000};
  // Idle timeout.
  std::chrono::milliseconds idle_limit{300'000};
  // Idle timeout before the first message, if shorter: the caller is not authenticated yet.
  std::chrono::milliseconds first_idle_limit{10'000};
  int max_metadata_bytes = 8 << 10;  // of one call, as HTTP/2 counts them
  // Budget for reservations of all calls (CallMemory).
  std::int64_t message_memory_bytes = 512 << 20;
};

// Limits of calls: number in flight, in total and for one client, by request class; duration; size
// of metadata. Thread-safe; outlives its slots.
class CallLimits {
 public:
  // A counted call in flight; the destructor releases it. Movable.
  class Slot {
   public:
    Slot() = default;
    Slot(Slot&& other) noexcept { *this = std::move(other); }
    Slot& operator=(Slot&& other) noexcept;
    ~Slot() { Release(); }

   private:
    friend class CallLimits;
    void Release();

    CallLimits* limits_ = nullptr;
    RequestClass request_class_ = RequestClass::kLight;
    std::string client_;
  };

  explicit CallLimits(const CallLimitOptions& options)
      : options_(options), limits_{options.calls, options.heavy, options.streams} {}

  const CallLimitOptions& options() const { return options_; }
  // Idle timeout before the first message.
  std::chrono::milliseconds first_message_limit() const {
    return std::min(options_.idle_limit, options_.first_idle_limit);
  }

  // True if the class has its own limit. Such calls enter twice, because all calls count as kLight.
  static bool HasOwnLimit(RequestClass request_class) {
    return request_class != RequestClass::kLight;
  }
  // RESOURCE_EXHAUSTED at a limit, with the name of the limit and the time to retry.
  absl::StatusOr<Slot> Enter(RequestClass request_class, const std::string& client);

  // RESOURCE_EXHAUSTED if a call has too much metadata.
  absl::Status CheckMetadata(std::size_t bytes) const;

  // Number of calls in flight of a class.
  int open(RequestClass request_class) const;

 private:
  // By class.
  using Counts = std::array<int, 3>;

  void Leave(RequestClass request_class, const std::string& client);

  const CallLimitOptions options_;
  const std::array<CallLimit, 3> limits_;
  mutable storage::Mutex mutex_;
  Counts in_all_ ABSL_GUARDED_BY(mutex_){};
  std::map<std::string, Counts> per_client_
      ABSL_GUARDED_BY(mutex_);  // only clients with calls in flight
};

// For error messages.
inline double Mebibytes(std::int64_t bytes) { return static_cast<double>(bytes) / (1 << 20); }

// Memory budget of all calls: parsed requests, uploaded files, motion, states and intermediate
// arrays of queries, and responses until they are sent. A call reserves memory before it allocates
// it. Thread-safe; outlives its reservations.
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
// sends and stored bytes that it names. docs/architecture.md, section Memory, has the rule and the
// upper bounds that calls reserve.
std::int64_t MaxCallMemory(std::int64_t size_bytes);

}  // namespace motiondb::server
