// One client of the HTTP server: reads a request, has its page made, writes the answer, and so on
// while the client keeps the connection. Used by one thread, its server's.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <functional>
#include <memory>
#include <optional>

#include "server/observability/http_server.h"

namespace motiondb::server {

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
