// How many calls may be under way at a time: of one client and in all, streams and heavy work
// apart. Thread-safe; outlives its slots.
#pragma once

#include <array>
#include <map>
#include <mutex>
#include <string>

#include "absl/status/statusor.h"

namespace motiondb::server {

// What a call asks of the server.
enum class CallWeight {
  kLight,   // milliseconds
  kHeavy,   // much processor time, memory or disk: plans, ingests, whole models, backups
  kStream,  // as long as the client likes, a little at a time
};

// The most of one kind.
struct CallLimit {
  int in_all = 0;
  int per_client = 0;
};

struct CallLimitOptions {
  CallLimit light{2048, 1024};
  CallLimit heavy{256, 64};
  CallLimit streams{1024, 256};
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
    CallWeight weight_ = CallWeight::kLight;
    std::string client_;
  };

  explicit CallLimits(const CallLimitOptions& options)
      : limits_{options.light, options.heavy, options.streams} {}

  // RESOURCE_EXHAUSTED, saying of what there is too much and when to try again, if it is taken up.
  absl::StatusOr<Slot> Enter(CallWeight weight, const std::string& client);

  // Calls of a kind that are under way.
  int open(CallWeight weight) const;

 private:
  // By weight.
  using Counts = std::array<int, 3>;

  void Leave(CallWeight weight, const std::string& client);

  const std::array<CallLimit, 3> limits_;
  mutable std::mutex mutex_;
  Counts in_all_{};
  std::map<std::string, Counts> per_client_;  // of those with a call under way
};

}  // namespace motiondb::server
