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

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
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

// One client of the HTTP server: reads a request, has its page made, writes the answer, and so on
// while the client keeps the connection. Used by one thread, its server's.
class HttpConnection;

// What connections ask of their server.
class HttpConnectionHost {
 public:
  virtual ~HttpConnectionHost() = default;
  virtual const HttpLimits& limits() const = 0;
  // The page of a path; null where there is none.
  virtual const HttpPage* FindPage(std::string_view path) const = 0;
  // Makes a page elsewhere and brings the answer back to this thread. False, and nothing comes,
  // where too many wait for pages already, in all or at this client address.
  virtual bool MakeElsewhere(const HttpPage& page, const boost::asio::ip::address& address,
                             std::function<void(HttpAnswer)> take) = 0;
  virtual void OnClosed(HttpConnection& connection) = 0;
};

class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  // The host must outlive the connection.
  HttpConnection(HttpConnectionHost& host, boost::asio::ip::tcp::socket socket);
  ~HttpConnection();
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;

  void Start() { Read(); }
  const boost::asio::ip::address& address() const { return address_; }
  // Ends it at once.
  void Close();

  // Since when the client keeps the server waiting; nothing while the server works.
  std::optional<std::chrono::steady_clock::time_point> waiting_since() const { return waiting_; }

 private:
  using Verb = boost::beast::http::verb;

  void Read();
  void OnRead(boost::beast::error_code error);
  void Respond();
  void Write(HttpAnswer answer, bool keep_alive);
  void OnWritten(boost::beast::error_code error);
  // Throws away what still comes, until the client closes: to close with bytes unread would take
  // the answer back that is on its way.
  void AwaitEnd();

  HttpConnectionHost& host_;
  const boost::asio::ip::address address_;  // of the client
  boost::beast::tcp_stream stream_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::string_body>> parser_;
  std::optional<boost::beast::http::response<boost::beast::http::string_body>> response_;
  std::optional<std::chrono::steady_clock::time_point> waiting_;
  bool closed_ = false;
};

}  // namespace motiondb::server
