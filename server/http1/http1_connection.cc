#include "server/http1/http1_connection.h"

#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <cerrno>
#include <limits>
#include <new>
#include <utility>

#include "text/utf8.h"

namespace motiondb::server {

namespace {

namespace http = boost::beast::http;

constexpr std::size_t kReadBytes = 16 << 10;        // maximum of one read
constexpr std::size_t kMaxInputBytes = 32 << 10;    // of pipelined requests
constexpr std::int64_t kMaxDroppedInput = 4 << 20;  // after the last response
constexpr std::chrono::seconds kPeerCloseTime{1};  // for the client to close after the server's end
// A client that has half-closed gets the responses that are ready within this time.
constexpr std::chrono::seconds kHalfClosedTime{2};

HttpResponse PlainText(http::status status, std::string reason) {
  return {.status = static_cast<unsigned>(status),
          .fields = {{"content-type", "text/plain; charset=utf-8"}},
          .body = std::move(reason) + "\n"};
}

HttpResponse ResponseTo(const boost::beast::error_code& error, std::uint32_t head_bytes) {
  if (error == http::error::header_limit) {
    return PlainText(http::status::request_header_fields_too_large,
                     fmt::format("expected at most {} bytes of headers", head_bytes));
  }
  if (error == http::error::bad_version) {
    return PlainText(http::status::http_version_not_supported, "expected HTTP/1.1");
  }
  return PlainText(http::status::bad_request, fmt::format("not HTTP/1.1: {}", error.message()));
}

// Beast of Debian 12 does not convert to std::string_view.
std::string LowerCaseOf(boost::beast::string_view text) {
  return text::LowerCase({text.data(), text.size()});
}

// Returns whether the client has closed the connection, or has reset it.
bool HasPeerClosed(int socket) {
  tcp_info info{};
  socklen_t size = sizeof(info);
  if (getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return false;
  return info.tcpi_state == TCP_CLOSE_WAIT || info.tcpi_state == TCP_CLOSE;
}

}  // namespace

std::string_view HttpRequest::Find(std::string_view name) const {
  const auto found =
      std::ranges::find_if(fields, [&](const auto& field) { return field.first == name; });
  return found == fields.end() ? std::string_view() : std::string_view(found->second);
}

Http1Connection::Http1Connection(HttpHandler& handler, const Http1Limits& limits,
                                 AcceptedClient client)
    : handler_(handler),
      limits_(limits),
      context_(client.context),
      guard_(client.context.get_executor()),
      bytes_(std::move(client.bytes)),
      peer_(std::move(client.peer)),
      on_closed_(std::move(client.on_closed)) {}

Http1Connection::~Http1Connection() = default;

void Http1Connection::Start() { Serve(); }

void Http1Connection::Post(std::function<void()> work) {
  boost::asio::post(context_, [self = shared_from_this(), work = std::move(work)] {
    try {
      work();
    } catch (const std::bad_alloc&) {  // the response would never come
      self->reason_ = "out of memory";
      return self->Close();
    }
    self->Serve();
  });
}

// Reads, answers and writes as far as the socket permits.
void Http1Connection::Serve() {
  if (closed_ || serving_) return;
  if (closing_since_.has_value()) return DropInput();
  serving_ = true;
  const auto self = shared_from_this();
  bool open = true;
  try {
    open = WriteSome() && ReadSome();
    // Several times if there are pipelined requests.
    while (HandleInput() && open && output_.size() > 0) open = WriteSome();
    if (parsed_ > 0) input_.erase(0, std::exchange(parsed_, 0));
    if (leaves_ || input_.empty()) std::string().swap(input_);
  } catch (const std::bad_alloc&) {
    reason_ = "out of memory";
    open = false;
  }
  serving_ = false;
  const bool is_done = leaves_ && output_.empty();
  const bool has_ended = input_ended_.has_value() && phase_ != Phase::kWork && output_.empty();
  if (!open || is_done || has_ended) Leave();
  if (!closed_) Await();
}

// Reads once. False: the connection has failed.
bool Http1Connection::ReadSome() {
  if (input_ended_.has_value() || leaves_ || input_.size() - parsed_ >= kMaxInputBytes) return true;
  static thread_local std::array<std::uint8_t, kReadBytes> buffer;
  errno = 0;
  const ByteStream::Result read = bytes_.Read(buffer);
  wants_write_ = read.outcome == ByteStream::Outcome::kWantsWrite;
  if (read.outcome == ByteStream::Outcome::kClosed) {
    input_ended_ = Clock::now();
    return errno != ECONNRESET;
  }
  if (read.outcome != ByteStream::Outcome::kDone) return true;
  if (!std::exchange(got_bytes_, true)) common_name_ = bytes_.CommonName();
  if (phase_ == Phase::kHead && input_.empty()) waiting_since_ = Clock::now();
  input_.append(reinterpret_cast<const char*>(buffer.data()), read.bytes);
  return true;
}

// Handles requests until one is incomplete, works, or has output that waits. False: it handled
// nothing.
bool Http1Connection::HandleInput() {
  const std::size_t before = parsed_;
  while (!leaves_ && !closed_) {
    if (phase_ == Phase::kWork || (phase_ == Phase::kHead && !output_.empty())) break;
    if (parsed_ == input_.size() || !(phase_ == Phase::kHead ? ParseHead() : ParseBody())) break;
  }
  return parsed_ > before;
}

// False: more input is needed.
bool Http1Connection::ParseHead() {
  if (!parser_.has_value()) {
    // Empty lines before a request are ignored (RFC 9112, section 2.2).
    while (parsed_ < input_.size() && (input_[parsed_] == '\r' || input_[parsed_] == '\n')) {
      ++parsed_;
    }
    if (parsed_ == input_.size()) return false;
    if (draining_) {
      leaves_ = true;
      return false;
    }
    parser_.emplace();
    parser_->header_limit(limits_.head_bytes);
    parser_->body_limit(std::numeric_limits<std::uint64_t>::max());  // HttpWork::Admit limits it
  }
  boost::beast::error_code error;
  const std::size_t size =
      parser_->put(boost::asio::buffer(input_.data() + parsed_, input_.size() - parsed_), error);
  parsed_ += size;
  // The limit of the parser is for one call of put.
  request_.bytes += size;
  if (request_.bytes > limits_.head_bytes) error = http::error::header_limit;
  if (error == http::error::need_more) return false;
  if (error) {
    Refuse(ResponseTo(error, limits_.head_bytes));
  } else if (parser_->is_header_done()) {
    OnHead();
  }
  return size > 0;
}

// Returns the response to a head that no handler may see; nullopt if it is valid.
std::optional<HttpResponse> Http1Connection::CheckHead() const {
  const auto& head = parser_->get();
  const auto invalid = [](std::string reason) {
    return PlainText(http::status::bad_request, std::move(reason));
  };
  if (head.method() == http::verb::unknown) {
    return PlainText(http::status::not_implemented, "unknown method");
  }
  const auto hosts = static_cast<int>(head.count(http::field::host));
  if (hosts > 1 || (hosts == 0 && head.version() == 11)) {
    return invalid(fmt::format("expected one Host header, got {}", hosts));
  }
  if (!head.target().starts_with('/')) return invalid("expected a path that begins with /");
  // Otherwise the body would be taken for the next request.
  const auto codings = head.count(http::field::transfer_encoding);
  if (codings > 0 &&
      (codings > 1 || LowerCaseOf(head[http::field::transfer_encoding]) != "chunked")) {
    return PlainText(http::status::not_implemented, "expected no Transfer-Encoding but chunked");
  }
  const auto expected = head[http::field::expect];
  if (!expected.empty() && LowerCaseOf(expected) != "100-continue") {
    return PlainText(http::status::expectation_failed, "expected no Expect but 100-continue");
  }
  return std::nullopt;
}

void Http1Connection::OnHead() {
  const auto& head = parser_->get();
  keeps_alive_ = head.keep_alive();
  request_.method = std::string(head.method_string());
  if (auto refusal = CheckHead()) return Refuse(*std::move(refusal));
  const std::string_view target(head.target().data(), head.target().size());
  request_.path = std::string(target.substr(0, target.find_first_of("?#")));
  request_.fields.reserve(16);
  for (const auto& field : head) {
    request_.fields.emplace_back(LowerCaseOf(field.name_string()), std::string(field.value()));
  }
  auto accepted = handler_.Accept(request_, shared_from_this());
  if (auto* const response = std::get_if<HttpResponse>(&accepted)) {
    return parser_->is_done() ? Respond(std::move(*response)) : Refuse(std::move(*response));
  }
  work_ = std::get<std::shared_ptr<HttpWork>>(std::move(accepted));
  const auto length = parser_->content_length();
  const std::uint64_t announced = length.has_value() ? *length : 0;
  constexpr std::uint64_t kMax = std::numeric_limits<std::int64_t>::max();
  if (auto refusal = work_->Admit(static_cast<std::int64_t>(std::min(announced, kMax)))) {
    return Refuse(*std::move(refusal));
  }
  if (parser_->is_done()) return OnBody();
  phase_ = Phase::kBody;
  waiting_since_ = Clock::now();
  parser_->eager(true);
  const bool waits = !head[http::field::expect].empty() && head.version() == 11;
  if (waits && parsed_ == input_.size()) Write("HTTP/1.1 100 Continue\r\n\r\n");
}

// False: more input is needed.
bool Http1Connection::ParseBody() {
  // The body grows by at most the input, less than kMaxInputBytes, before it is admitted.
  boost::beast::error_code error;
  const std::size_t size =
      parser_->put(boost::asio::buffer(input_.data() + parsed_, input_.size() - parsed_), error);
  parsed_ += size;
  if (error && error != http::error::need_more) {
    Refuse(ResponseTo(error, limits_.head_bytes));
    return false;
  }
  const auto body_bytes = static_cast<std::int64_t>(parser_->get().body().size());
  if (parser_->chunked()) {
    if (auto refusal = work_->Admit(body_bytes)) {
      Refuse(*std::move(refusal));
      return false;
    }
  }
  if (parser_->is_done()) {
    OnBody();
    return true;
  }
  // A line of a chunk that does not fit.
  if (input_.size() - parsed_ >= kMaxInputBytes) {
    Refuse(PlainText(http::status::bad_request, "not HTTP/1.1: line too long"));
  }
  return size > 0;
}

void Http1Connection::OnBody() {
  phase_ = Phase::kWork;
  calls_ = 1;
  const auto work = work_;  // a copy: it may end the request
  work->Start(std::move(parser_->get().body()));
}

// Responds to a request whose body was not read; so the connection cannot be used again.
void Http1Connection::Refuse(HttpResponse response) {
  CancelWork();
  keeps_alive_ = false;
  Respond(std::move(response));
}

void Http1Connection::Await() {
  using Socket = boost::asio::ip::tcp::socket;
  const bool reads = closing_since_.has_value() ||
                     (!leaves_ && !input_ended_.has_value() && input_.size() < kMaxInputBytes &&
                      (phase_ == Phase::kWork || output_.empty()));
  if (reads && !closing_since_.has_value() && bytes_.HasPending()) {
    boost::asio::post(context_, [self = shared_from_this()] { self->Serve(); });
  } else if (reads && !std::exchange(awaiting_read_, true)) {
    bytes_.socket().async_wait(Socket::wait_read, [self = shared_from_this()](auto) {
      self->awaiting_read_ = false;
      self->Serve();
    });
  }
  const bool writes = !closing_since_.has_value() && (!output_.empty() || wants_write_);
  if (writes && !std::exchange(awaiting_write_, true)) {
    bytes_.socket().async_wait(Socket::wait_write, [self = shared_from_this()](auto) {
      self->awaiting_write_ = false;
      self->Serve();
    });
  }
}

void Http1Connection::Tick(Clock::time_point now) {
  if (closed_) return;
  if (closing_since_.has_value()) {
    if (now - *closing_since_ > kPeerCloseTime) Close();
    return;
  }
  if (!output_.empty() && now > output_since_ + output_time_) {
    reason_ = "the client reads too slowly";
    return Close();
  }
  // A connection with much input does not read, so that it would not notice.
  const bool is_full = phase_ == Phase::kWork && input_.size() >= kMaxInputBytes;
  if (is_full && !input_ended_.has_value() && HasPeerClosed(bytes_.socket().native_handle())) {
    input_ended_ = now;
  }
  if (input_ended_.has_value() && now - *input_ended_ > kHalfClosedTime) return Close();
  const auto waited = now - waiting_since_;
  const auto size = static_cast<std::int64_t>(
      parser_.has_value() && phase_ == Phase::kBody ? parser_->get().body().size() : 0);
  const std::chrono::milliseconds allowance(size / limits_.bytes_per_millisecond);
  if (phase_ == Phase::kBody && waited > limits_.body_time + allowance) {
    Refuse(PlainText(http::status::request_timeout, "the body of the request arrives too slowly"));
    return Serve();
  }
  if (phase_ != Phase::kHead || !output_.empty()) return;
  if (parser_.has_value() && waited > limits_.head_time) {
    Refuse(PlainText(http::status::request_timeout, "the head of the request arrives too slowly"));
    return Serve();
  }
  if (waited > (got_bytes_ ? limits_.idle_time : limits_.head_time)) Leave();
}

void Http1Connection::Drain() {
  draining_ = true;
  if (phase_ == Phase::kHead && !parser_.has_value() && output_.empty()) Leave();
}

// Stops sending. Input is read and dropped until the client closes: closing a socket with unread
// bytes resets it, and the client could lose the last output.
void Http1Connection::Leave() {
  if (closed_ || closing_since_.has_value()) return;
  closing_since_ = Clock::now();
  CancelWork();
  answered_.reset();  // it refers to the connection
  std::string().swap(output_);
  std::string().swap(input_);
  bytes_.EndWriting();
  Await();
}

void Http1Connection::DropInput() {
  static thread_local std::array<std::uint8_t, kReadBytes> buffer;
  for (int i = 0; i < 4; ++i) {
    const ssize_t size = recv(bytes_.socket().native_handle(), buffer.data(), buffer.size(), 0);
    const bool is_open = size > 0 || (size < 0 && (errno == EAGAIN || errno == EINTR));
    dropped_ += std::max<ssize_t>(size, 0);
    if (!is_open || dropped_ > kMaxDroppedInput) return Close();
    if (size < 0) break;
  }
  Await();
}

void Http1Connection::CancelWork() {
  if (const auto work = std::exchange(work_, nullptr)) work->Cancel();
  calls_ = 0;
}

void Http1Connection::Close() {
  if (std::exchange(closed_, true)) return;
  CancelWork();
  answered_.reset();
  bytes_.Close();
  on_closed_(shared_from_this(), reason_);
}

}  // namespace motiondb::server
