#include "server/observability/http_connection.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

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

}  // namespace motiondb::server
