// One connection of a client: its bytes (plain or TLS), its HTTP/2 session (libnghttp2), and its
// streams, one for each call. It stays on one thread. Its cost is bounded:
// - it is closed after too many HTTP/2 frames without a call;
// - it does not read while output waits for the socket;
// - it is closed if no HTTP/2 frame arrives in time, or if a ping gets no reply.
// CallStream bounds the headers and messages of a stream.
#pragma once

#include <nghttp2/nghttp2.h>

#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/http2/call_stream.h"
#include "server/http2/frame_guard.h"
#include "server/listen/client_connection.h"

namespace motiondb::server {

using Session = std::unique_ptr<nghttp2_session, decltype(&nghttp2_session_del)>;

class Connection final : public ClientConnection,
                         public StreamConnection,
                         public std::enable_shared_from_this<Connection> {
 public:
  using Clock = ClientConnection::Clock;

  // `bridge` must outlive the connection.
  Connection(CallBridge& bridge, AcceptedClient client);
  ~Connection() override;

  void Start() override;
  void Tick(Clock::time_point now) override;
  // Sends a GOAWAY that permits all streams (RFC 9113, 6.8).
  void BeginDrain() override;
  // Sends GOAWAY and begins no more calls.
  void Drain() override;
  void Close() override;
  int calls() const override { return calls_.load(std::memory_order_relaxed); }

  nghttp2_session* session() override { return session_.get(); }
  void Post(std::function<void()> work) override;
  const std::string& peer() const override { return peer_; }
  const std::string& common_name() const override { return common_name_; }
  bool draining() const override { return draining_; }

 private:
  friend struct SessionCallbacks;

  enum class Turn { kReadAndWrite, kWrite };
  void Serve(Turn turn = Turn::kReadAndWrite);
  void FlushSoon();
  void Leave();
  void DetachStreams();
  void DropInput();
  bool ReadSome();
  bool WriteSome();
  void Await();
  void End(const char* reason);
  CallStream* Find(std::int32_t id);

  CallBridge& bridge_;
  boost::asio::io_context& context_;
  // Keeps the thread running: gRPC may post to it until the last stream is released.
  const boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_;
  ByteStream bytes_;
  const std::string peer_;
  std::string common_name_;
  const AcceptedClient::OnClosed on_closed_;
  Session session_;
  std::map<std::int32_t, std::shared_ptr<CallStream>> streams_;
  std::vector<std::shared_ptr<CallStream>> starting_streams_;  // begin at the end of this turn
  std::atomic<int> calls_ = 0;

  std::vector<std::uint8_t> unsent_;  // output that the socket has not accepted yet
  bool wants_write_ = false;
  bool awaiting_read_ = false;
  bool awaiting_write_ = false;
  bool serving_ = false;
  bool flushing_ = false;  // a flush is posted
  bool closed_ = false;
  bool draining_ = false;
  std::optional<Clock::time_point> closing_since_;  // time since which nothing is sent
  std::int64_t dropped_ = 0;                        // bytes received since `closing_since_`
  std::string reason_;                              // why the server closes it

  Clock::time_point last_activity_ = began();  // last time that bytes were read or written
  bool pinged_ = false;                        // a ping was sent after `last_activity_`
  bool got_frame_ = false;                     // an HTTP/2 frame has arrived
  FrameGuard frames_{began()};
  std::int64_t calls_begun_ = 0;
  std::size_t chunk_ = 4096;  // size of the next read, bytes
};

// Returns a server-side HTTP/2 session of libnghttp2. Its callbacks (session.cc) pass headers and
// data to the streams of the connection, which must outlive it. Flow control is manual, by
// nghttp2_session_consume. Throws std::bad_alloc.
Session NewSession(Connection& connection);

}  // namespace motiondb::server
