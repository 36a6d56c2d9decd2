// What calls may take: how many may be under way at a time, of one client and in all, and of those
// that are heavy or last; how long they may be, and how much may come with one. Thread-safe;
// outlives its slots.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "server/security/role_table.h"
#include "storage/mutex.h"

namespace motiondb::server {

// A client that takes an answer slower than this ends its call.
inline constexpr std::int64_t kSlowestBytesPerMillisecond = 64;

struct CallLimit {
  int in_all = 0;
  int per_client = 0;
};

struct CallLimitOptions {
  CallLimit calls{4096, 1024};  // of every class
  CallLimit heavy{256, 64};
  CallLimit streams{1024, 256};
  // Whatever the client's own deadline. Streams of frames may go on; a wait for an operation, which
  // takes no thread, has a timeout of its own.
  std::chrono::milliseconds longest_call{600'000};
  // That a client which sends a stream may stay silent.
  std::chrono::milliseconds longest_silence{300'000};
  // That it may before its first message, if that is less: nobody knows yet who it is.
  std::chrono::milliseconds longest_first_silence{10'000};
  int max_metadata_bytes = 8 << 10;  // that come with a call, as HTTP/2 counts them
  // That calls may reserve (CallMemory).
  std::int64_t message_memory_bytes = 512 << 20;
};

class CallLimits {
 public:
  // A call's place; free again when it is destroyed. Movable.
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
  // How long a client may be silent before its first message.
  std::chrono::milliseconds first_silence() const {
    return std::min(options_.longest_silence, options_.longest_first_silence);
  }

  // Whether calls of a class are limited by themselves. All calls count as kLight: these enter
  // twice.
  static bool HasOwnLimit(RequestClass request_class) {
    return request_class != RequestClass::kLight;
  }
  // RESOURCE_EXHAUSTED, saying of what there is too much and when to try again.
  absl::StatusOr<Slot> Enter(RequestClass request_class, const std::string& client);

  // RESOURCE_EXHAUSTED for a call that comes with more metadata than it may.
  absl::Status CheckMetadata(std::size_t bytes) const;

  // Calls of a class that are under way.
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
      ABSL_GUARDED_BY(mutex_);  // of those with a call under way
};

}  // namespace motiondb::server
