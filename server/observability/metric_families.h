// Collects metrics of Prometheus, and adds those of the store.
#pragma once

#include <prometheus/metric_family.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "text/display_text.h"

namespace motiondb::server {

struct ServerStatistics;

// Collects families of metrics. Not thread-safe.
class MetricFamilies {
 public:
  using Labels = std::vector<prometheus::ClientMetric::Label>;
  using Type = prometheus::MetricType;

  // A family of one series without labels.
  void Add(Type type, const char* name, const char* help, double value, Labels labels = {}) {
    Begin(type, name, help);
    Put(std::move(labels), value);
  }
  // Starts a family; Put adds series to it.
  void Begin(Type type, const char* name, const char* help) {
    families_.push_back({name, help, type, {}});
  }
  void Put(Labels labels, double value) {
    prometheus::ClientMetric metric;
    metric.label = Shown(std::move(labels));
    metric.gauge.value = metric.counter.value = value;  // the type of the family selects one
    families_.back().metric.push_back(std::move(metric));
  }
  void PutSummary(Labels labels, std::int64_t count, double sum) {
    prometheus::ClientMetric metric;
    metric.label = Shown(std::move(labels));
    metric.summary.sample_count = static_cast<std::uint64_t>(count);
    metric.summary.sample_sum = sum;
    families_.back().metric.push_back(std::move(metric));
  }
  std::vector<prometheus::MetricFamily> Take() && { return std::move(families_); }

 private:
  // Stores of earlier versions may have database names with control characters.
  static Labels Shown(Labels labels) {
    for (auto& label : labels) label.value = text::SafeText(label.value);
    return labels;
  }

  std::vector<prometheus::MetricFamily> families_;
};

// Metrics of the store, and of the server's part in a store that several servers share.
void AddStore(const ServerStatistics& statistics, MetricFamilies& families);

}  // namespace motiondb::server
