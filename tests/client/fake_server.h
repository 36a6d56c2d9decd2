// A gRPC server on loopback that returns canned responses to every call of the wire contract and
// records the requests. Thread-safe: calls run on gRPC's threads.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace motiondb::v1 {
class DatabaseStatistics;
class GetDatabaseResponse;
}  // namespace motiondb::v1

namespace motiondb::tests {

// The response of GetDatabase with DATABASE_VIEW_FULL.
v1::GetDatabaseResponse WithStatistics(const v1::DatabaseStatistics& statistics);

class FakeServer {
 public:
  // The result of a call: an error, or messages (one, unless it streams).
  struct Reply {
    int code = 0;
    std::string message;
    std::string details;  // bytes of grpc-status-details-bin
    std::vector<std::string> messages;
    int delay_milliseconds = 0;
  };

  FakeServer();
  ~FakeServer();

  // HOST:PORT.
  const std::string& address() const { return address_; }

  // Adds a reply for `rpc`. Replies are used in order; the last one is repeated. A call without a
  // reply fails with UNIMPLEMENTED.
  void Push(const std::string& rpc, Reply reply);

  template <typename... Messages>
  void Answer(const std::string& rpc, const Messages&... messages) {
    Push(rpc, {0, "", "", {messages.SerializeAsString()...}});
  }

  void Fail(const std::string& rpc, int code, const std::string& message,
            const std::string& details = "") {
    Push(rpc, {code, message, details, {}});
  }

  // Returns the requests in order; for an ingest, every message of the stream.
  template <typename Request>
  std::vector<Request> Requests(const std::string& rpc) const {
    const std::lock_guard lock(mutex_);
    std::vector<Request> requests;
    if (const auto found = requests_.find(rpc); found != requests_.end()) {
      for (const std::string& bytes : found->second) requests.emplace_back().ParseFromString(bytes);
    }
    return requests;
  }

  // Returns the headers of the calls in order.
  using Headers = std::map<std::string, std::string>;
  std::vector<Headers> HeadersOf(const std::string& rpc) const;

  // Used by the services.
  void Keep(const std::string& rpc, std::string request);
  void KeepHeaders(const std::string& rpc, Headers headers);
  Reply Next(const std::string& rpc);

 private:
  struct Services;

  void Listen();

  mutable std::mutex mutex_;
  std::map<std::string, std::vector<Reply>> replies_;
  std::map<std::string, std::vector<std::string>> requests_;
  std::map<std::string, std::vector<Headers>> headers_;
  std::string address_;
  std::unique_ptr<Services> services_;
};

}  // namespace motiondb::tests
