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

// Of a request line with its headers, and of a body, which no page wants.
constexpr std::size_t kHeaderLimit = 8192;
constexpr std::size_t kBodyLimit = 1024;

// That a client has to close a connection after its last answer.
constexpr std::chrono::milliseconds kFarewell{1000};

HttpAnswer Refusal(http::status status, std::string why) {
  return {.status = static_cast<unsigned>(status), .body = std::move(why) + "\n"};
}

// Unspecified where the client is gone already.
boost::asio::ip::address AddressOf(const boost::asio::ip::tcp::socket& socket) {
  beast::error_code error;
  return socket.remote_endpoint(error).address();
}

// The answer to what is no request; nothing where the client is gone or was too slow, which is the
// end without a word.
std::optional<HttpAnswer> AnswerTo(beast::error_code error) {
  if (error == http::error::header_limit) {
    return Refusal(http::status::request_header_fields_too_large,
                   fmt::format("expected at most {} bytes of headers", kHeaderLimit));
  }
  if (error == http::error::body_limit) {
    return Refusal(http::status::payload_too_large, "expected a request without a body");
  }
  const bool is_cut = error == http::error::end_of_stream || error == http::error::partial_message;
  if (is_cut || error.category() != http::make_error_code(http::error::bad_method).category()) {
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
  // Without Close only where an exception, or the end of the server, dropped what it waited for.
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
    return Write(Refusal(http::status::not_found, "no such page; / lists those there are"),
                 keep_alive);
  }
  if (request.method() != Verb::get && request.method() != Verb::head) {
    return Write(Refusal(http::status::method_not_allowed, "expected GET or HEAD"), keep_alive);
  }
  if (page->at_once) return Write(page->make(), keep_alive);
  const bool is_coming = host_.MakeElsewhere(
      *page, address_, [self = shared_from_this(), keep_alive](HttpAnswer answer) {
        if (!self->closed_) self->Write(std::move(answer), keep_alive);
      });
  if (is_coming) return;
  Write(Refusal(http::status::service_unavailable, "too many wait for pages already"), keep_alive);
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
  // The headers of a HEAD are those that GET would bring.
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
  // The client learns the end from the end of the stream.
  stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, error);
  waiting_ = Clock::now();
  stream_.expires_after(std::min(kFarewell, host_.limits().request_time));
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

// How long to wait where a connection cannot be taken, as where no descriptor is left.
constexpr std::chrono::milliseconds kRest{100};
constexpr int kMostAcceptedAtOnce = 1024;

class BeastHttpServer final : public HttpServer, public HttpConnectionHost {
  using Take = std::function<void(HttpAnswer)>;

 public:
  BeastHttpServer(HttpPages pages, const HttpLimits& limits)
      : pages_(std::move(pages)), limits_(limits) {}

  ~BeastHttpServer() override {
    makers_.Join();
    talker_.Stop();
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

  bool MakeElsewhere(const HttpPage& page, const asio::ip::address& address, Take take) override {
    // Half are left to pages made at once: those who wait here cannot be made to make room. Half of
    // the rest is left to other addresses.
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
    asio::post(makers_.executor(), [this, &page] {
      asio::post(talker_.executor(), [this, &page, answer = page.make()] { Hand(page, answer); });
    });
    return true;
  }

  void OnClosed(HttpConnection& connection) override {
    if (connections_.erase(&connection) == 0) return;  // no memory was left to admit it
    const auto of_address = count_by_address_.find(connection.address());
    if (--of_address->second == 0) count_by_address_.erase(of_address);
  }

 private:
  void Accept() {
    acceptor_.async_wait(tcp::acceptor::wait_read,
                         [this](const boost::system::error_code& stopped) {
                           if (stopped) return;
                           if (AcceptWaiting()) return Accept();
                           rest_.expires_after(kRest);
                           rest_.async_wait([this](const boost::system::error_code& cancelled) {
                             if (!cancelled) Accept();
                           });
                         });
  }

  // Takes the clients in the queue, many between two rounds of answers: a flood that is answered
  // slowly must not keep the others in the queue. False if a resource is exhausted.
  bool AcceptWaiting() {
    for (int taken = 0; taken < kMostAcceptedAtOnce; ++taken) {
      boost::system::error_code error;
      tcp::socket socket = acceptor_.accept(error);
      if (error == asio::error::would_block) return true;
      if (error == asio::error::connection_aborted) continue;
      if (error) return false;
      Admit(std::move(socket));
    }
    return true;
  }

  // Gives all who asked for a page while it was made what came of it.
  void Hand(const HttpPage& page, const HttpAnswer& answer) {
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

  // Closes the connection that has kept us waiting longest, of the address that has most
  // connections: a client at an address of its own keeps its place. False where each waits for us.
  bool MakeRoom() {
    HttpConnection* slowest = nullptr;
    for (HttpConnection* const connection : connections_) {
      if (!connection->waiting_since()) continue;
      if (slowest == nullptr) {
        slowest = connection;
        continue;
      }
      const int count = count_by_address_[connection->address()];
      const int most = count_by_address_[slowest->address()];
      const bool is_slower = *connection->waiting_since() < *slowest->waiting_since();
      if (count > most || (count == most && is_slower)) slowest = connection;
    }
    if (slowest == nullptr) return false;
    slowest->Close();
    return true;
  }

  const HttpPages pages_;
  const HttpLimits limits_;
  std::string address_;
  bool is_loopback_ = false;
  // Each is kept by what it waits for. Before the threads, which end what they wait for.
  std::unordered_set<HttpConnection*> connections_;
  std::map<asio::ip::address, int> count_by_address_;
  ThreadPool talker_{1};
  struct Taker {
    asio::ip::address address;
    Take take;
  };
  std::map<const HttpPage*, std::vector<Taker>> takers_;  // of each page that is being made
  int waiting_ = 0;                                       // of them all
  std::map<asio::ip::address, int> waiting_by_address_;
  tcp::acceptor acceptor_{talker_.context()};
  asio::steady_timer rest_{talker_.context()};
  ThreadPool makers_{1};
};

}  // namespace

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::Start(const std::string& listen,
                                                              HttpPages pages, HttpLimits limits) {
  auto server = std::make_unique<BeastHttpServer>(std::move(pages), limits);
  MOTIONDB_RETURN_IF_ERROR(server->Listen(listen));
  return server;
}

}  // namespace motiondb::server
