// A small HTTP/1.1 server for metrics and health pages: GET and HEAD only, no authentication.
// Thread-safe; owns its socket and two threads, one for sockets and one that makes pages.
//
// Bounds: the size of a request, the time to receive it and to send the response, and the number of
// connections. At the limit, a new connection replaces the slowest client of the address with the
// most connections. So slow or faulty clients do not lock out others.
// A slow page is made once for all requests that arrive meanwhile. At most half of the connections
// may wait for slow pages, a quarter from one address; further requests get 503. So immediate pages
// are always served.
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
  bool is_immediate = false;         // immediate page: made without waiting for other pages
};

using HttpPages = std::map<std::string, HttpPage, std::less<>>;  // by path, "/metrics"

struct HttpLimits {
  int connections = 64;
  std::chrono::milliseconds request_time{5000};   // to receive a request, idle time included
  std::chrono::milliseconds answer_time{10'000};  // to send a response
};

class HttpServer {
 public:
  // Listens at HOST:PORT and serves the pages; port 0 selects a free port. Errors: those of
  // ListenOn.
  static absl::StatusOr<std::unique_ptr<HttpServer>> Start(const std::string& listen,
                                                           HttpPages pages, HttpLimits limits = {});
  // Closes all connections. Waits for a page that is being made.
  virtual ~HttpServer() = default;

  // HOST:PORT for clients.
  virtual const std::string& address() const = 0;
  // True if only this machine can reach it.
  virtual bool is_loopback() const = 0;
};

class HttpConnection;

// Interface of the server for its connections.
class HttpConnectionHost {
 public:
  virtual ~HttpConnectionHost() = default;
  virtual const HttpLimits& limits() const = 0;
  // Returns the page of a path; null if there is none.
  virtual const HttpPage* FindPage(std::string_view path) const = 0;
  // Makes a page on another thread, then calls `take` on this thread. Returns false, without a
  // call, if too many requests wait for pages already, in total or from this client address.
  virtual bool MakeInBackground(const HttpPage& page, const boost::asio::ip::address& address,
                                std::function<void(HttpAnswer)> take) = 0;
  virtual void OnClosed(HttpConnection& connection) = 0;
};

// One client: reads a request, gets its page, writes the response, and repeats while the connection
// is kept alive. Runs only on the server's socket thread.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  // The host must outlive the connection.
  HttpConnection(HttpConnectionHost& host, boost::asio::ip::tcp::socket socket);
  ~HttpConnection();
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;

  void Start() { Read(); }
  const boost::asio::ip::address& address() const { return address_; }
  // Closes it immediately.
  void Close();

  // Time since which the server waits for the client; nullopt while the server works.
  std::optional<std::chrono::steady_clock::time_point> waiting_since() const { return waiting_; }

 private:
  using Verb = boost::beast::http::verb;

  void Read();
  void OnRead(boost::beast::error_code error);
  void Respond();
  void Write(HttpAnswer answer, bool keep_alive);
  void OnWritten(boost::beast::error_code error);
  // Reads and drops input until the client closes: closing a socket with unread bytes resets it,
  // and the client could lose the response.
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
