#include "server/observability/call_meter.h"

#include <prometheus/counter.h>
#include <prometheus/histogram.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace motiondb::server {

namespace {

constexpr const char* kOther = "other";

// Upper bounds of the buckets: from one frame of a stream to a plan over a large database.
const prometheus::Histogram::BucketBoundaries kSeconds{
    0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30, 60, 300};

constexpr std::string_view kCodeNames[] = {
    "OK",        "CANCELLED",      "UNKNOWN",           "INVALID_ARGUMENT",   "DEADLINE_EXCEEDED",
    "NOT_FOUND", "ALREADY_EXISTS", "PERMISSION_DENIED", "RESOURCE_EXHAUSTED", "FAILED_PRECONDITION",
    "ABORTED",   "OUT_OF_RANGE",   "UNIMPLEMENTED",     "INTERNAL",           "UNAVAILABLE",
    "DATA_LOSS", "UNAUTHENTICATED"};

// All codes, in order.
constexpr auto kCodes = [] {
  std::array<absl::StatusCode, std::size(kCodeNames)> codes{};
  for (std::size_t i = 0; i < codes.size(); ++i) codes[i] = static_cast<absl::StatusCode>(i);
  return codes;
}();

std::size_t IndexOf(absl::StatusCode code) {
  const auto index = static_cast<std::size_t>(code);
  return index < std::size(kCodeNames) ? index
                                       : static_cast<std::size_t>(absl::StatusCode::kUnknown);
}

}  // namespace

bool IsServerFault(absl::StatusCode code) {
  return code == absl::StatusCode::kInternal || code == absl::StatusCode::kUnknown ||
         code == absl::StatusCode::kDataLoss;
}

std::string_view CodeName(absl::StatusCode code) { return kCodeNames[IndexOf(code)]; }

CallMeter::CallMeter(prometheus::Registry& registry, const std::vector<std::string>& methods)
    : requests_(prometheus::BuildCounter()
                    .Name("motiondb_requests_total")
                    .Help("Calls ended, by method and status code.")
                    .Register(registry)),
      seconds_(prometheus::BuildHistogram()
                   .Name("motiondb_request_seconds")
                   .Help("Duration of calls, by method; for streams, how long they were open.")
                   .Register(registry)),
      authentication_failures_(prometheus::BuildCounter()
                                   .Name("motiondb_authentication_failures_total")
                                   .Help("Calls refused because authentication failed.")
                                   .Register(registry)
                                   .Add({})) {
  static_assert(std::size(kCodeNames) == Method::kCodeCount);
  Add(kOther);
  for (const std::string& name : methods) Add(name);
}

CallMeter::~CallMeter() = default;

void CallMeter::Add(const std::string& name) {
  auto method = std::make_unique<Method>();
  method->name_ = name;
  method->seconds_ = &seconds_.Add({{"method", name}}, kSeconds);
  // Exports 0 from the start: a rate, and an alert on the first error, need a previous value.
  for (const absl::StatusCode code : kCodes) {
    if (code == absl::StatusCode::kOk || IsServerFault(code)) CounterOf(*method, code);
  }
  methods_.emplace(name, std::move(method));
}

CallMeter::Method& CallMeter::Find(std::string_view name) {
  const auto found = methods_.find(name);
  return found != methods_.end() ? *found->second : *methods_.find(kOther)->second;
}

prometheus::Counter& CallMeter::CounterOf(Method& method, absl::StatusCode code) {
  auto& slot = method.by_code_[IndexOf(code)];
  prometheus::Counter* counter = slot.load(std::memory_order_acquire);
  if (counter == nullptr) {
    // The family returns the same counter for the same labels.
    counter = &requests_.Add({{"method", method.name_}, {"code", std::string(CodeName(code))}});
    slot.store(counter, std::memory_order_release);
  }
  return *counter;
}

void CallMeter::Begin(CallKind kind) {
  open_.fetch_add(1, std::memory_order_relaxed);
  if (kind == CallKind::kFrames) open_streams_.fetch_add(1, std::memory_order_relaxed);
}

void CallMeter::End(Method& method, CallKind kind, absl::StatusCode code, double seconds) {
  open_.fetch_sub(1, std::memory_order_relaxed);
  if (kind == CallKind::kFrames) open_streams_.fetch_sub(1, std::memory_order_relaxed);
  CounterOf(method, code).Increment();
  method.seconds_->Observe(seconds);
  if (code == absl::StatusCode::kUnauthenticated) authentication_failures_.Increment();
}

void CallMeter::CountRefusedAttempt() { authentication_failures_.Increment(); }

std::int64_t CallMeter::Count(const Method& method, absl::StatusCode code) {
  const auto* const counter = method.by_code_[IndexOf(code)].load(std::memory_order_acquire);
  return counter != nullptr ? static_cast<std::int64_t>(counter->Value()) : 0;
}

std::int64_t CallMeter::Sum(const std::function<bool(absl::StatusCode)>& counts) const {
  std::int64_t sum = 0;
  for (const auto& [name, method] : methods_) {
    for (const absl::StatusCode code : kCodes) {
      if (counts(code)) sum += Count(*method, code);
    }
  }
  return sum;
}

std::int64_t CallMeter::ended() const {
  return Sum([](absl::StatusCode) { return true; });
}

std::int64_t CallMeter::failed() const { return Sum(IsServerFault); }

std::int64_t CallMeter::authentication_failures() const {
  return static_cast<std::int64_t>(authentication_failures_.Value());
}

std::vector<MethodStatistics> CallMeter::Methods() const {
  std::vector<MethodStatistics> methods;
  for (const auto& [name, method] : methods_) {
    MethodStatistics statistics{.method = name};
    for (const absl::StatusCode code : kCodes) {
      const std::int64_t count = Count(*method, code);
      statistics.ended += count;
      if (code != absl::StatusCode::kOk && count > 0) statistics.errors.emplace_back(code, count);
    }
    if (statistics.ended == 0) continue;
    statistics.seconds = EstimateQuantiles(method->seconds_->Collect().histogram);
    methods.push_back(std::move(statistics));
  }
  return methods;
}

double EstimateQuantile(const prometheus::ClientMetric::Histogram& histogram, double quantile) {
  if (histogram.sample_count == 0) return 0;
  const double rank = quantile * static_cast<double>(histogram.sample_count);
  const auto& buckets = histogram.bucket;
  const auto bucket = std::find_if(buckets.begin(), buckets.end(), [&](const auto& candidate) {
    return static_cast<double>(candidate.cumulative_count) >= rank;
  });
  double begin = 0, before = 0;
  if (bucket != buckets.begin()) {
    begin = std::prev(bucket)->upper_bound;
    before = static_cast<double>(std::prev(bucket)->cumulative_count);
  }
  if (bucket == buckets.end() || std::isinf(bucket->upper_bound)) return begin;
  const double inside = static_cast<double>(bucket->cumulative_count) - before;
  const double share = inside > 0 ? (rank - before) / inside : 0;
  return std::lerp(begin, bucket->upper_bound, share);
}

CallQuantiles EstimateQuantiles(const prometheus::ClientMetric::Histogram& histogram) {
  return {.p50 = EstimateQuantile(histogram, 0.50),
          .p95 = EstimateQuantile(histogram, 0.95),
          .p99 = EstimateQuantile(histogram, 0.99)};
}

}  // namespace motiondb::server
