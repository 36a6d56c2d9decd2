// Counts calls and how long they took, by method and code, and those under way, and connections.
// Thread-safe; a call costs two atomic additions and the short lock that prometheus-cpp puts around
// a histogram, which calls of one method share.
#pragma once

#include <prometheus/client_metric.h>
#include <prometheus/registry.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"

namespace prometheus {
class Counter;
class Histogram;
}  // namespace prometheus

namespace motiondb::server {

// In seconds; all 0 of an empty histogram.
struct CallQuantiles {
  double p50 = 0;
  double p95 = 0;
  double p99 = 0;
};

// The value that a share `quantile` (0 to 1) of the observations does not exceed, linear between
// the bounds of its bucket, the lowest of which begins at 0: what Prometheus' histogram_quantile
// says. Of the last bucket, which has no end, its beginning. 0 of an empty histogram.
double EstimateQuantile(const prometheus::ClientMetric::Histogram& histogram, double quantile);

CallQuantiles EstimateQuantiles(const prometheus::ClientMetric::Histogram& histogram);

// Who decides how long a call lasts.
enum class CallKind {
  kWork,    // the server, by its work
  kWait,    // somebody else: a build that is waited for, a client that sends or takes a file
  kFrames,  // the client, which streams frames as long as it likes
};

// True of the codes that say that the server, not its caller, did something wrong.
bool IsOwnFault(absl::StatusCode code);

// "NOT_FOUND".
std::string_view CodeName(absl::StatusCode code);

// Calls of one method that ended.
struct MethodFigures {
  std::string method;
  std::int64_t ended = 0;
  std::vector<std::pair<absl::StatusCode, std::int64_t>>
      errors;  // in order of code, none of 0 calls
  CallQuantiles seconds;
};

class CallMeter {
 public:
  // One method's share. Owned by the meter.
  class Method {
   public:
    const std::string& name() const { return name_; }

   private:
    friend class CallMeter;
    static constexpr int kCodeCount = 17;
    std::string name_;
    std::array<std::atomic<prometheus::Counter*>, kCodeCount> by_code_{};
    prometheus::Histogram* seconds_ = nullptr;
  };

  // The registry must outlive the meter. Methods are named "Service.Method"; each is
  // exported from the start, with no call yet.
  CallMeter(prometheus::Registry& registry, const std::vector<std::string>& methods);
  ~CallMeter();

  // The method of that name, or the one under which all unknown ones are counted.
  Method& Find(std::string_view name);

  void Begin(CallKind kind);
  // UNAUTHENTICATED counts as a failure to authenticate.
  void End(Method& method, CallKind kind, absl::StatusCode code, double seconds);
  // One more failure to authenticate, of a call that ends otherwise: it was not even looked at.
  void CountRefusedAttempt();

  // Calls ended, and of these those that failed by the server's own fault.
  std::int64_t ended() const;
  std::int64_t failed() const;
  std::int64_t authentication_failures() const;
  // Methods of which calls have ended, in order of name.
  std::vector<MethodFigures> Methods() const;
  int open() const { return open_.load(std::memory_order_relaxed); }
  int open_streams() const { return open_streams_.load(std::memory_order_relaxed); }

 private:
  prometheus::Counter& CounterOf(Method& method, absl::StatusCode code);
  void Add(const std::string& name);
  // Calls of the method that ended with this code.
  static std::int64_t Count(const Method& method, absl::StatusCode code);
  std::int64_t Sum(const std::function<bool(absl::StatusCode)>& counts) const;

  prometheus::Family<prometheus::Counter>& requests_;
  prometheus::Family<prometheus::Histogram>& seconds_;
  prometheus::Counter& authentication_failures_;
  std::map<std::string, std::unique_ptr<Method>, std::less<>> methods_;  // constant after the start
  std::atomic<int> open_{0};
  std::atomic<int> open_streams_{0};
};

// Counts clients' connections.
struct ConnectionMeter {
  std::atomic<int> open = 0;
  std::atomic<std::int64_t> refused =
      0;  // for lack of descriptors, or as one too many of an address
  std::atomic<std::int64_t> ended =
      0;  // by the server, for what a client sent or for lack of memory
};

}  // namespace motiondb::server
