// Clients that load a server: each asks again as soon as it has its answer, and notes how long that
// took. Functions keep no state.
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

// What a load came to. Plain values.
struct Load {
  std::vector<double> ms;  // from question to answer, each
  double seconds = 0;      // that they were asked in
  // Processor time of the whole process meanwhile: servers' and clients'.
  double processor_seconds = 0;

  double rate() const { return static_cast<double>(ms.size()) / seconds; }
  // Processor time of one answer, on both ends.
  double processor_ms() const { return 1e3 * processor_seconds / static_cast<double>(ms.size()); }
  // The time that this part (0 to 1) of the answers came within. NaN without answers.
  double Within(double part) const;
  void Add(const Load& more);
};

// One client with a connection of its own. One thread at a time.
class LoadClient {
 public:
  virtual ~LoadClient() = default;
  // A message out and its answer back.
  virtual absl::Status Ask() = 0;
  // The last answer, serialized.
  virtual std::string Reply() const = 0;
};

// Recognizes each of the requests in turn, beginning with `first`. `requests` outlive it.
std::unique_ptr<LoadClient> NewRecognizeClient(const std::string& address,
                                               const std::vector<v1::RecognizeRequest>& requests,
                                               std::size_t first);

// Opens a stream, with `start` unless it is null, and sends each of the messages in turn, over and
// over, with frames numbered on. Destroying it ends the stream.
std::unique_ptr<LoadClient> NewObserveClient(const std::string& address,
                                             const v1::ObserveRequest* start,
                                             std::vector<v1::ObserveRequest> messages);

// All clients at once, a thread each, for so long, after each has asked `warm_up` times.
// The first error of any.
absl::StatusOr<Load> AskAll(const std::vector<std::unique_ptr<LoadClient>>& clients, int warm_up,
                            Seconds duration);

// One client that has a question every `period`, while `going` says so. A question waits while the
// one before it is not answered, and that counts: its time runs from when it was due.
absl::StatusOr<Load> AskEvery(LoadClient& client, Seconds period,
                              const std::function<bool()>& going);

}  // namespace motiondb::tests
