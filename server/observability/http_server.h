// A small HTTP/1.1 server for pages that machines read: GET and HEAD, nothing else. Meant for
// metrics and health; there is no authentication. Thread-safe; owns its socket and two threads, one
// that talks and one that makes pages.
//
// What a client may cost is bounded: the size of a request, the time until it is whole and until
// its answer is taken, and the connections at a time. At the limit the one that has kept the server
// waiting longest makes room, of those of the address that has most connections, so clients that
// send slowly, nothing or garbage lock nobody out.
// A page that takes time is made once for all who ask meanwhile, and half of the connections may
// wait for such pages, a quarter from one address, further requests being refused (503): however
// long one takes, pages made at once are answered.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace motiondb::server {

struct HttpAnswer {
  unsigned status = 200;
  std::string content_type = "text/plain; charset=utf-8";
  std::string body;
};

struct HttpPage {
  std::function<HttpAnswer()> make;  // must not throw; called by one thread at a time
  bool at_once = false;              // it takes no time: made without waiting for other pages
};

using HttpPages = std::map<std::string, HttpPage, std::less<>>;  // by path, "/metrics"

struct HttpLimits {
  int connections = 64;
  std::chrono::milliseconds request_time{5000};   // until a request is whole, idling included
  std::chrono::milliseconds answer_time{10'000};  // until an answer is taken
};

class HttpServer {
 public:
  // Listens at HOST:PORT, port 0 for a free one, and answers from then on. Codes: INVALID_ARGUMENT
  // (no HOST:PORT), UNAVAILABLE (cannot be listened on).
  static absl::StatusOr<std::unique_ptr<HttpServer>> Start(const std::string& listen,
                                                           HttpPages pages, HttpLimits limits = {});
  // Cuts what still runs. Waits for a page that is being made.
  virtual ~HttpServer() = default;

  // HOST:PORT that clients reach it at.
  virtual const std::string& address() const = 0;
  // True if only this machine reaches it.
  virtual bool is_loopback() const = 0;
};

}  // namespace motiondb::server
