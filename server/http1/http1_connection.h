// One connection of an HTTP/1.1 client: its bytes (plain or TLS), its requests one after the other
// (keep-alive, pipelining, Expect: 100-continue), and their responses. It stays on one thread. Its
// cost is bounded:
// - by limits on the size of a head and on input that waits, and by HttpWork::Admit;
// - it does not read further requests while output waits for the socket;
// - it ends if a head, a body or the reading of a response takes too long.
#pragma once

#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "server/http1/http_exchange.h"
#include "server/listen/client_connection.h"

namespace motiondb::server {

struct Http1Limits {
  std::uint32_t head_bytes = 16 << 10;
  std::chrono::milliseconds head_time{20'000};     // to receive a head; also for the TLS handshake
  std::chrono::milliseconds idle_time{60'000};     // between requests
  std::chrono::milliseconds body_time{10'000};     // to receive a body, plus its size by the rate
  std::chrono::milliseconds answer_time{300'000};  // to read output, plus its size by the rate
  std::int64_t bytes_per_millisecond = 64;         // the minimum rate
};

class Http1Connection final : public ClientConnection,
                              public HttpExchange,
                              public std::enable_shared_from_this<Http1Connection> {
 public:
  // `handler` must outlive the connection.
  Http1Connection(HttpHandler& handler, const Http1Limits& limits, AcceptedClient client);
  ~Http1Connection() override;

  void Start() override;
  void Tick(Clock::time_point now) override;
  // Closes after the next response.
  void BeginDrain() override { is_last_response_ = true; }
  void Drain() override;
  void Close() override;
  void Post(std::function<void()> work) override;
  int calls() const override { return calls_.load(std::memory_order_relaxed); }

  const std::string& peer() const override { return peer_; }
  const std::string& common_name() const override { return common_name_; }
  bool draining() const override { return draining_; }
  void Respond(HttpResponse response) override;
  void BeginStream(HttpResponse head, std::optional<std::size_t> body_bytes) override;
  void SendPart(std::string part) override;
  void EndStream() override;

 private:
  using Parser = boost::beast::http::request_parser<boost::beast::http::string_body>;
  enum class Phase { kHead, kBody, kWork };

  void Serve();
  bool ReadSome();
  bool WriteSome();
  void Await();
  bool HandleInput();
  bool ParseHead();
  bool ParseBody();
  void OnHead();
  std::optional<HttpResponse> CheckHead() const;
  void OnBody();
  void Refuse(HttpResponse response);
  void WriteHead(const HttpResponse& response, std::optional<std::size_t> body_bytes);
  void Write(std::string_view bytes);
  void EndRequest();
  void Leave();
  void DropInput();
  void CancelWork();

  HttpHandler& handler_;
  const Http1Limits limits_;
  boost::asio::io_context& context_;
  // Keeps the thread running: work may post to it until it is released.
  const boost::asio::executor_work_guard<boost::asio::io_context::executor_type> guard_;
  ByteStream bytes_;
  const std::string peer_;
  std::string common_name_;
  const AcceptedClient::OnClosed on_closed_;

  std::string input_;  // received and not parsed yet, from `parsed_`
  std::size_t parsed_ = 0;
  std::optional<Parser> parser_;  // of the request that is being received or answered
  HttpRequest request_;
  std::shared_ptr<HttpWork> work_;
  std::shared_ptr<HttpWork> answered_;  // keeps its memory reserved until the output is written
  Phase phase_ = Phase::kHead;
  std::atomic<int> calls_ = 0;

  std::string output_;  // not accepted by the socket yet, from `written_`
  std::size_t written_ = 0;
  bool chunked_ = false;  // the response has chunks; otherwise its end is that of the connection
  bool reports_sent_ = false;  // OnSent is due when the output is written
  bool keeps_alive_ = false;   // a further request may follow the response
  bool leaves_ = false;        // closes when the output is written
  bool wants_write_ = false;   // of TLS
  bool awaiting_read_ = false;
  bool awaiting_write_ = false;
  bool serving_ = false;
  bool closed_ = false;
  bool is_last_response_ = false;
  bool draining_ = false;
  bool got_bytes_ = false;
  std::optional<Clock::time_point> input_ended_;    // the client has half-closed
  std::optional<Clock::time_point> closing_since_;  // time since which nothing is sent
  std::int64_t dropped_ = 0;                        // bytes received since `closing_since_`
  std::string reason_;                              // why the server closes it
  Clock::time_point waiting_since_ = began();  // begin of the idle time, of the head or of the body
  // Slow readers: since when output waits, and how long the output of the response may still wait.
  Clock::time_point output_since_;
  Clock::duration output_time_ = limits_.answer_time;
};

}  // namespace motiondb::server
