// Counts calls by method and code, their durations, and calls in flight.
// A call costs two atomic additions and a short lock of prometheus-cpp on the histogram of its
// method. Thread-safe.
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

// In seconds; all 0 if the histogram is empty.
struct CallQuantiles {
  double p50 = 0;
  double p95 = 0;
  double p99 = 0;
};

// Returns the quantile (`quantile` is 0 to 1) like Prometheus' histogram_quantile: linear between
// the bounds of its bucket. The lowest bucket begins at 0. In the last bucket, which has no end, it
// is the lower bound. 0 if the histogram is empty.
double EstimateQuantile(const prometheus::ClientMetric::Histogram& histogram, double quantile);

CallQuantiles EstimateQuantiles(const prometheus::ClientMetric::Histogram& histogram);

// What determines the duration of a call.
enum class CallKind {
  kWork,    // the work of the server
  kWait,    // waiting for a build, or for a client that sends or receives a file
  kFrames,  // the client, which streams frames without a limit
};

// True for codes that mean a fault of the server: INTERNAL, UNKNOWN, DATA_LOSS.
bool IsServerFault(absl::StatusCode code);

// "NOT_FOUND".
std::string_view CodeName(absl::StatusCode code);

// Calls of one method that ended.
struct MethodStatistics {
  std::string method;
  std::int64_t ended = 0;
  std::vector<std::pair<absl::StatusCode, std::int64_t>>
      errors;  // in order of code; only codes that occurred
  CallQuantiles seconds;
};

class CallMeter {
 public:
  // Counters of one method. Owned by the meter.
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

  // The registry must outlive the meter. `methods`: names such as "Service.Method". All of them are
  // exported from the start, also without a call.
  CallMeter(prometheus::Registry& registry, const std::vector<std::string>& methods);
  ~CallMeter();

  // Returns the method of that name, or the common one for unknown names.
  Method& Find(std::string_view name);

  void Begin(CallKind kind);
  // Counts UNAUTHENTICATED also as an authentication failure.
  void End(Method& method, CallKind kind, absl::StatusCode code, double seconds);
  // Counts an authentication failure of a call that ends with another code, because its credentials
  // were not checked.
  void CountRefusedAttempt();

  // Ended calls, and those of them that failed by the server's fault.
  std::int64_t ended() const;
  std::int64_t failed() const;
  std::int64_t authentication_failures() const;
  // Methods with ended calls, in order of name.
  std::vector<MethodStatistics> Methods() const;
  int open() const { return open_.load(std::memory_order_relaxed); }
  int open_streams() const { return open_streams_.load(std::memory_order_relaxed); }

 private:
  prometheus::Counter& CounterOf(Method& method, absl::StatusCode code);
  void Add(const std::string& name);
  // Returns the number of ended calls of the method with this code.
  static std::int64_t Count(const Method& method, absl::StatusCode code);
  std::int64_t Sum(const std::function<bool(absl::StatusCode)>& counts) const;

  prometheus::Family<prometheus::Counter>& requests_;
  prometheus::Family<prometheus::Histogram>& seconds_;
  prometheus::Counter& authentication_failures_;
  std::map<std::string, std::unique_ptr<Method>, std::less<>>
      methods_;  // never changes after construction
  std::atomic<int> open_{0};
  std::atomic<int> open_streams_{0};
};

}  // namespace motiondb::server
