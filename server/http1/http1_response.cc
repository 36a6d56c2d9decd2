// Responses of an HTTP/1.1 connection: heads, chunks, and their output.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <boost/beast/http/status.hpp>
#include <ctime>
#include <optional>
#include <span>
#include <utility>

#include "server/http1/http1_connection.h"

namespace motiondb::server {

void Http1Connection::Respond(HttpResponse response) {
  if (closed_ || closing_since_.has_value()) return;
  chunked_ = false;
  const bool has_length = response.status != 304;  // it would be that of another response
  WriteHead(response, has_length ? std::optional(response.body.size()) : std::nullopt);
  if (request_.method != "HEAD") Write(response.body);
  EndRequest();
}

void Http1Connection::BeginStream(HttpResponse head, std::optional<std::size_t> body_bytes) {
  if (closed_ || closing_since_.has_value()) return;
  chunked_ = !body_bytes.has_value() && parser_->get().version() == 11;
  keeps_alive_ = keeps_alive_ && (chunked_ || body_bytes.has_value());
  WriteHead(head, body_bytes);
}

void Http1Connection::SendPart(std::string part) {
  if (closed_ || closing_since_.has_value() || part.empty()) return;
  if (chunked_) Write(fmt::format("{:x}\r\n", part.size()));
  Write(part);
  if (chunked_) Write("\r\n");
  reports_sent_ = true;
}

void Http1Connection::EndStream() {
  if (closed_ || closing_since_.has_value()) return;
  if (chunked_) Write("0\r\n\r\n");
  EndRequest();
}

void Http1Connection::WriteHead(const HttpResponse& response,
                                std::optional<std::size_t> body_bytes) {
  output_time_ = limits_.answer_time;
  keeps_alive_ = keeps_alive_ && !is_last_response_ && !draining_ && !input_ended_.has_value();
  const auto reason =
      boost::beast::http::obsolete_reason(static_cast<boost::beast::http::status>(response.status));
  std::string head = fmt::format(
      "HTTP/1.1 {} {}\r\nserver: motiondbd\r\ndate: {:%a, %d %b %Y %T} GMT\r\n", response.status,
      std::string_view(reason.data(), reason.size()), fmt::gmtime(std::time(nullptr)));
  for (const auto& [name, value] : response.fields) head += fmt::format("{}: {}\r\n", name, value);
  if (body_bytes.has_value()) {
    head += fmt::format("content-length: {}\r\n", *body_bytes);
  } else if (chunked_) {
    head += "transfer-encoding: chunked\r\n";
  }
  const bool is_http11 = parser_.has_value() && parser_->get().version() == 11;
  if (!keeps_alive_) head += "connection: close\r\n";
  if (keeps_alive_ && !is_http11) head += "connection: keep-alive\r\n";
  Write(head + "\r\n");
}

void Http1Connection::Write(std::string_view bytes) {
  if (output_.empty()) output_since_ = Clock::now();
  output_ += bytes;
  // Over the whole response: otherwise a client could take a block of it each `answer_time`.
  output_time_ += std::chrono::microseconds(1000 * static_cast<std::int64_t>(bytes.size()) /
                                            limits_.bytes_per_millisecond);
}

void Http1Connection::EndRequest() {
  answered_ = std::move(work_);
  parser_.reset();
  request_ = {};
  reports_sent_ = false;
  phase_ = Phase::kHead;
  calls_ = 0;
  waiting_since_ = Clock::now();
  if (!keeps_alive_) leaves_ = true;
}

// Writes output until the socket accepts no more. False: the connection has ended.
bool Http1Connection::WriteSome() {
  while (!output_.empty()) {
    const std::span<const std::uint8_t> rest(
        reinterpret_cast<const std::uint8_t*>(output_.data()) + written_,
        output_.size() - written_);
    const ByteStream::Result result = bytes_.Write(rest);
    if (result.outcome == ByteStream::Outcome::kClosed) return false;
    if (result.outcome != ByteStream::Outcome::kDone) return true;
    written_ += result.bytes;
    if (written_ < output_.size()) continue;
    std::string().swap(output_);
    written_ = 0;
    output_time_ -= Clock::now() - output_since_;
    answered_.reset();
    const auto work = work_;  // a copy: it may end the request
    if (std::exchange(reports_sent_, false) && work != nullptr) work->OnSent();
  }
  return true;
}

}  // namespace motiondb::server
