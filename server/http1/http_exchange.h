// A request of HTTP/1.1 and its response, between a connection and the code that answers. Without
// Beast, whose headers are large.
//
// A handler accepts or refuses each request by its head. An accepted request has a work, which gets
// the body and responds through the exchange. All functions run on the thread of the connection,
// except where noted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace motiondb::server {

using HttpFields = std::vector<std::pair<std::string, std::string>>;

// The head of a request.
struct HttpRequest {
  std::string method;  // "POST"
  std::string path;    // "/a/b": the target without query; begins with '/'
  HttpFields fields;   // names in lower case, in the order of the request
  std::size_t bytes = 0;

  // Returns the value of a field; the first of several; empty if there is none.
  std::string_view Find(std::string_view name) const;
};

struct HttpResponse {
  unsigned status = 200;
  HttpFields fields;  // without those of the connection: length, encoding of the transfer, date
  std::string body;
};

// The client of one request. Responses for a client that has disconnected are dropped.
class HttpExchange {
 public:
  virtual ~HttpExchange() = default;

  // Address of the client, "ipv4:127.0.0.1:50000", and the common name of its certificate, or "".
  virtual const std::string& peer() const = 0;
  virtual const std::string& common_name() const = 0;
  // True: no new work may begin, because the server is about to stop.
  virtual bool draining() const = 0;
  // Runs `work` on the connection's thread, then sends pending output. Callable from any thread.
  virtual void Post(std::function<void()> work) = 0;

  // Ends the request. Call it once, or BeginStream, any number of SendPart, and EndStream.
  virtual void Respond(HttpResponse response) = 0;
  // The body of `head` is not used. `body_bytes`: size of all parts together, if it is known.
  virtual void BeginStream(HttpResponse head,
                           std::optional<std::size_t> body_bytes = std::nullopt) = 0;
  // HttpWork::OnSent follows.
  virtual void SendPart(std::string part) = 0;
  virtual void EndStream() = 0;
};

// The answer to one request that was accepted.
class HttpWork {
 public:
  virtual ~HttpWork() = default;

  // Called before memory for `body_bytes` of the body in total is allocated. Returns the response
  // if the body is too large; it ends the request.
  virtual std::optional<HttpResponse> Admit(std::int64_t body_bytes) = 0;
  // The request is complete. Called once.
  virtual void Start(std::string body) = 0;
  // The socket has accepted all parts so far.
  virtual void OnSent() = 0;
  // The client has disconnected or is too slow. Nothing is called afterwards.
  virtual void Cancel() = 0;
};

// Thread-safe: shared by the connections of all threads.
class HttpHandler {
 public:
  virtual ~HttpHandler() = default;
  virtual std::variant<HttpResponse, std::shared_ptr<HttpWork>> Accept(
      const HttpRequest& request, const std::shared_ptr<HttpExchange>& exchange) = 0;
};

}  // namespace motiondb::server
