#include "server/observability/http_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "server/engine/thread_pool.h"
#include "server/observability/listen_on.h"

namespace motiondb::server {

namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using Clock = std::chrono::steady_clock;

// In bytes: request line with headers, and body. No page uses a body.
constexpr std::size_t kHeaderLimit = 8192;
constexpr std::size_t kBodyLimit = 1024;

// Time for the client to close a connection after its last response.
constexpr std::chrono::milliseconds kCloseTime{1000};

HttpAnswer Refusal(http::status status, std::string reason) {
  return {.status = static_cast<unsigned>(status), .body = std::move(reason) + "\n"};
}

// Returns an unspecified address if the client has already disconnected.
boost::asio::ip::address AddressOf(const boost::asio::ip::tcp::socket& socket) {
  beast::error_code error;
  return socket.remote_endpoint(error).address();
}

// Returns the response to an invalid request; nullopt if the client disconnected or was too slow:
// then the connection is closed without a response.
std::optional<HttpAnswer> AnswerTo(beast::error_code error) {
  if (error == http::error::header_limit) {
    return Refusal(http::status::request_header_fields_too_large,
                   fmt::format("expected at most {} bytes of headers", kHeaderLimit));
  }
  if (error == http::error::body_limit) {
    return Refusal(http::status::payload_too_large, "expected a request without a body");
  }
  const bool is_disconnect =
      error == http::error::end_of_stream || error == http::error::partial_message;
  if (is_disconnect ||
      error.category() != http::make_error_code(http::error::bad_method).category()) {
    return std::nullopt;
  }
  return Refusal(http::status::bad_request, fmt::format("not HTTP/1.1: {}", error.message()));
}

}  // namespace

HttpConnection::HttpConnection(HttpConnectionHost& host, boost::asio::ip::tcp::socket socket)
    : host_(host),
      address_(AddressOf(socket)),
      stream_(std::move(socket)),
      buffer_(kHeaderLimit + kBodyLimit) {}

HttpConnection::~HttpConnection() {
  // Close was not called if an exception or the end of the server dropped the pending handler.
  if (!closed_) host_.OnClosed(*this);
}

void HttpConnection::Close() {
  if (std::exchange(closed_, true)) return;
  stream_.close();
  host_.OnClosed(*this);
}

void HttpConnection::Read() {
  parser_.emplace();
  parser_->header_limit(kHeaderLimit);
  parser_->body_limit(kBodyLimit);
  waiting_ = Clock::now();
  stream_.expires_after(host_.limits().request_time);
  http::async_read(
      stream_, buffer_, *parser_,
      [self = shared_from_this()](beast::error_code error, std::size_t) { self->OnRead(error); });
}

void HttpConnection::OnRead(beast::error_code error) {
  if (closed_) return;
  waiting_.reset();
  if (!error) return Respond();
  auto answer = AnswerTo(error);
  if (!answer) return Close();
  Write(*std::move(answer), false);
}

void HttpConnection::Respond() {
  const auto& request = parser_->get();
  const bool keep_alive = request.keep_alive();
  const auto target = request.target();
  std::string_view path(target.data(), target.size());
  path = path.substr(0, path.find('?'));
  const HttpPage* const page = host_.FindPage(path);
  if (page == nullptr) {
    return Write(Refusal(http::status::not_found, "unknown page; see / for a list"), keep_alive);
  }
  if (request.method() != Verb::get && request.method() != Verb::head) {
    return Write(Refusal(http::status::method_not_allowed, "expected GET or HEAD"), keep_alive);
  }
  if (page->is_immediate) return Write(page->make(), keep_alive);
  const bool is_coming = host_.MakeInBackground(
      *page, address_, [self = shared_from_this(), keep_alive](HttpAnswer answer) {
        if (!self->closed_) self->Write(std::move(answer), keep_alive);
      });
  if (is_coming) return;
  Write(Refusal(http::status::service_unavailable, "too many requests wait for pages; retry later"),
        keep_alive);
}

void HttpConnection::Write(HttpAnswer answer, bool keep_alive) {
  response_.emplace();
  response_->result(answer.status);
  response_->set(http::field::server, "motiondbd");
  response_->set(http::field::content_type, answer.content_type);
  response_->set(http::field::cache_control, "no-store");
  if (response_->result() == http::status::method_not_allowed) {
    response_->set(http::field::allow, "GET, HEAD");
  }
  response_->keep_alive(keep_alive);
  response_->content_length(answer.body.size());
  // HEAD returns the same headers as GET.
  if (parser_->get().method() != Verb::head) response_->body() = std::move(answer.body);
  waiting_ = Clock::now();
  stream_.expires_after(host_.limits().answer_time);
  http::async_write(stream_, *response_,
                    [self = shared_from_this()](beast::error_code error, std::size_t) {
                      self->OnWritten(error);
                    });
}

void HttpConnection::OnWritten(beast::error_code error) {
  if (closed_) return;
  waiting_.reset();
  if (error) return Close();
  if (!response_->need_eof()) return Read();
  // The end of the stream marks the end of the response.
  stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, error);
  waiting_ = Clock::now();
  stream_.expires_after(std::min(kCloseTime, host_.limits().request_time));
  AwaitEnd();
}

void HttpConnection::AwaitEnd() {
  buffer_.clear();
  stream_.async_read_some(buffer_.prepare(kBodyLimit),
                          [self = shared_from_this()](beast::error_code error, std::size_t) {
                            if (self->closed_) return;
                            if (error) return self->Close();
                            self->AwaitEnd();
                          });
}

namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

// Time before the next attempt if no connection can be accepted, such as without a free descriptor.
constexpr std::chrono::milliseconds kAcceptRetry{100};
constexpr int kMaxAcceptedPerTurn = 1024;

class BeastHttpServer final : public HttpServer, public HttpConnectionHost {
  using Take = std::function<void(HttpAnswer)>;

 public:
  BeastHttpServer(HttpPages pages, const HttpLimits& limits)
      : pages_(std::move(pages)), limits_(limits) {}

  ~BeastHttpServer() override {
    page_thread_.Join();
    socket_thread_.Stop();
  }

  absl::Status Listen(const std::string& listen) {
    if (const absl::Status status = ListenOn(listen, acceptor_); !status.ok()) {
      return absl::Status(status.code(), fmt::format("HTTP: {}", std::string(status.message())));
    }
    is_loopback_ = acceptor_.local_endpoint().address().is_loopback();
    address_ = fmt::format("{}:{}", listen.substr(0, listen.rfind(':')),
                           acceptor_.local_endpoint().port());
    acceptor_.non_blocking(true);
    Accept();
    return absl::OkStatus();
  }

  const std::string& address() const override { return address_; }
  bool is_loopback() const override { return is_loopback_; }

  const HttpLimits& limits() const override { return limits_; }

  const HttpPage* FindPage(std::string_view path) const override {
    const auto found = pages_.find(path);
    return found == pages_.end() ? nullptr : &found->second;
  }

  bool MakeInBackground(const HttpPage& page, const asio::ip::address& address,
                        Take take) override {
    // A waiting connection cannot be replaced. So half of the connections are reserved for
    // immediate pages, and half of the rest for other addresses.
    if (waiting_ >= std::max(1, limits_.connections / 2)) return false;
    const auto waiting_there = waiting_by_address_.find(address);
    if (waiting_there != waiting_by_address_.end() &&
        waiting_there->second >= std::max(1, limits_.connections / 4)) {
      return false;
    }
    ++waiting_;
    ++waiting_by_address_[address];
    std::vector<Taker>& takers = takers_[&page];
    takers.push_back({address, std::move(take)});
    if (takers.size() > 1) return true;
    asio::post(page_thread_.executor(), [this, &page] {
      asio::post(socket_thread_.executor(),
                 [this, &page, answer = page.make()] { Deliver(page, answer); });
    });
    return true;
  }

  void OnClosed(HttpConnection& connection) override {
    if (connections_.erase(&connection) == 0) return;  // Admit ran out of memory
    const auto entry = count_by_address_.find(connection.address());
    if (--entry->second == 0) count_by_address_.erase(entry);
  }

 private:
  void Accept() {
    acceptor_.async_wait(
        tcp::acceptor::wait_read, [this](const boost::system::error_code& stopped) {
          if (stopped) return;
          if (AcceptWaiting()) return Accept();
          accept_retry_.expires_after(kAcceptRetry);
          accept_retry_.async_wait([this](const boost::system::error_code& cancelled) {
            if (!cancelled) Accept();
          });
        });
  }

  // Accepts many waiting clients in one turn of the event loop, so that a flood of requests does
  // not leave others in the accept queue. False if a resource is exhausted.
  bool AcceptWaiting() {
    for (int taken = 0; taken < kMaxAcceptedPerTurn; ++taken) {
      boost::system::error_code error;
      tcp::socket socket = acceptor_.accept(error);
      if (error == asio::error::would_block) return true;
      if (error == asio::error::connection_aborted) continue;
      if (error) return false;
      Admit(std::move(socket));
    }
    return true;
  }

  // Sends the page to all requests that arrived while it was made.
  void Deliver(const HttpPage& page, const HttpAnswer& answer) {
    const std::vector<Taker> takers = std::exchange(takers_[&page], {});
    waiting_ -= static_cast<int>(takers.size());
    for (const Taker& taker : takers) {
      const auto waiting_there = waiting_by_address_.find(taker.address);
      if (--waiting_there->second == 0) waiting_by_address_.erase(waiting_there);
    }
    for (const Taker& taker : takers) taker.take(answer);
  }

  void Admit(tcp::socket socket) {
    if (static_cast<int>(connections_.size()) >= limits_.connections && !MakeRoom()) return;
    const auto connection = std::make_shared<HttpConnection>(*this, std::move(socket));
    int& count = count_by_address_[connection->address()];
    connections_.insert(connection.get());
    ++count;
    connection->Start();
  }

  // Closes the connection with the longest wait for its client, of the address with the
  // most connections. False if no connection waits for its client.
  bool MakeRoom() {
    HttpConnection* slowest = nullptr;
    for (HttpConnection* const connection : connections_) {
      if (!connection->waiting_since()) continue;
      if (slowest == nullptr) {
        slowest = connection;
        continue;
      }
      const int count = count_by_address_[connection->address()];
      const int slowest_count = count_by_address_[slowest->address()];
      const bool is_slower = *connection->waiting_since() < *slowest->waiting_since();
      if (count > slowest_count || (count == slowest_count && is_slower)) slowest = connection;
    }
    if (slowest == nullptr) return false;
    slowest->Close();
    return true;
  }

  const HttpPages pages_;
  const HttpLimits limits_;
  std::string address_;
  bool is_loopback_ = false;
  // Pending handlers own the connections; stopping the threads, which are declared below, drops
  // them.
  std::unordered_set<HttpConnection*> connections_;
  std::map<asio::ip::address, int> count_by_address_;
  ThreadPool socket_thread_{1};
  struct Taker {
    asio::ip::address address;
    Take take;
  };
  std::map<const HttpPage*, std::vector<Taker>> takers_;  // by page that is being made
  int waiting_ = 0;                                       // in total
  std::map<asio::ip::address, int> waiting_by_address_;
  tcp::acceptor acceptor_{socket_thread_.context()};
  asio::steady_timer accept_retry_{socket_thread_.context()};
  ThreadPool page_thread_{1};
};

}  // namespace

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::Start(const std::string& listen,
                                                              HttpPages pages, HttpLimits limits) {
  auto server = std::make_unique<BeastHttpServer>(std::move(pages), limits);
  MOTIONDB_RETURN_IF_ERROR(server->Listen(listen));
  return server;
}

}  // namespace motiondb::server
