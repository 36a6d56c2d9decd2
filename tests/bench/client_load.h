// Clients that load a server. Each sends the next request when it has its answer, and records
// latencies.
#pragma once

#include <grpcpp/channel.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "motiondb/v1/observe.pb.h"
#include "motiondb/v1/query.pb.h"

namespace motiondb::tests {

using Seconds = std::chrono::duration<double>;

// The result of a load.
struct Load {
  std::vector<double> ms;  // latency of each request
  double seconds = 0;      // duration of the load
  // Processor time of the whole process meanwhile: servers and clients.
  double processor_seconds = 0;

  double rate() const { return static_cast<double>(ms.size()) / seconds; }
  // Returns the processor time of one answer, on both ends.
  double processor_ms() const { return 1e3 * processor_seconds / static_cast<double>(ms.size()); }
  // Returns the quantile `part` (0 to 1) of the latencies, ms. NaN without answers.
  double LatencyQuantile(double part) const;
  void Add(const Load& more);
};

// One client with its own connection. Used by one thread at a time.
class LoadClient {
 public:
  virtual ~LoadClient() = default;
  // Sends a message and reads its answer.
  virtual absl::Status Ask() = 0;
  // Returns the last answer, serialized.
  virtual std::string Reply() const = 0;
};

// Recognizes the requests cyclically, starting with `first`. `requests` must outlive the client.
std::unique_ptr<LoadClient> NewRecognizeClient(const std::string& address,
                                               const std::vector<v1::RecognizeRequest>& requests,
                                               std::size_t first);

// Opens a stream, with `start` unless it is null, and sends the messages cyclically with continued
// frame numbers. The destructor ends the stream.
std::unique_ptr<LoadClient> NewObserveClient(const std::string& address,
                                             const v1::ObserveRequest* start,
                                             std::vector<v1::ObserveRequest> messages);

// Runs all clients concurrently for `duration`, one thread each, after `warm_up` requests of each.
// Returns the first error of any client.
absl::StatusOr<Load> RunConcurrently(const std::vector<std::unique_ptr<LoadClient>>& clients,
                                     int warm_up, Seconds duration);

// Runs one client that sends a request every `period` while `going` returns true. A request waits
// for the answer to the previous one; its latency counts from its scheduled time.
absl::StatusOr<Load> RunPeriodically(LoadClient& client, Seconds period,
                                     const std::function<bool()>& going);

}  // namespace motiondb::tests
