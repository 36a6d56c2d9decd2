// One connection of a client: its bytes (plain or TLS), its HTTP/2 session (libnghttp2), and its
// streams, each a call. Lives on one thread; what it may cost is bounded:
// - HTTP/2 frames that carry no call are counted, and too many end the connection;
// - nothing is read while what was answered cannot be written;
// - it ends if its first bytes are no HTTP/2 within a time, and if a ping is not answered.
// A stream's headers and messages are bounded by CallStream.
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

#include "server/http2/byte_stream.h"
#include "server/http2/call_stream.h"
#include "server/http2/frame_guard.h"

namespace motiondb::server {

using Session = std::unique_ptr<nghttp2_session, decltype(&nghttp2_session_del)>;

class Connection final : public StreamHost, public std::enable_shared_from_this<Connection> {
 public:
  using Clock = std::chrono::steady_clock;

  // Told when a connection has ended, on its thread, and what its client did that it had to; empty
  // where the client left.
  using OnClosed =
      std::function<void(const std::shared_ptr<Connection>&, const std::string& reason)>;

  Connection(CallBridge& bridge, boost::asio::io_context& context, ByteStream bytes,
             std::string peer, OnClosed on_closed);
  ~Connection() override;

  void Start();
  // To be called about once a second: looks after everything that takes too long.
  void Tick(Clock::time_point now);
  // Tells the client to make its next calls elsewhere, and begins none any more.
  void Drain();
  void Close();

  // How many calls are open; safe to read from any thread.
  int calls() const { return calls_.load(std::memory_order_relaxed); }
  Clock::time_point began() const { return began_; }

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
  void LetGoOfStreams();
  void DropInput();
  bool ReadSome();
  bool WriteSome();
  void Await();
  void End(const char* reason);
  CallStream* Find(std::int32_t id);

  CallBridge& bridge_;
  boost::asio::io_context& context_;
  // Until the last stream has let go of the connection, gRPC may post to its thread.
  const boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_;
  ByteStream bytes_;
  const std::string peer_;
  std::string common_name_;
  const OnClosed on_closed_;
  Session session_;
  std::map<std::int32_t, std::shared_ptr<CallStream>> streams_;
  std::vector<std::shared_ptr<CallStream>> beginning_;  // at the end of the present turn
  std::atomic<int> calls_ = 0;

  std::vector<std::uint8_t> unsent_;  // what the socket has not taken yet
  bool wants_write_ = false;
  bool awaiting_read_ = false;
  bool awaiting_write_ = false;
  bool serving_ = false;
  bool flushing_ = false;  // soon
  bool closed_ = false;
  bool draining_ = false;
  std::optional<Clock::time_point> leaving_;  // since when nothing is sent any more
  std::int64_t dropped_ = 0;                  // bytes that came since
  std::string reason_;                        // why it has to end

  const Clock::time_point began_ = Clock::now();
  Clock::time_point heard_ = began_;  // when bytes last went either way
  bool pinged_ = false;               // and nothing was heard since
  bool greeted_ = false;              // the client has begun to speak HTTP/2
  FrameGuard frames_{began_};
  std::int64_t calls_begun_ = 0;
  std::size_t chunk_ = 4096;  // to read next
};

// The HTTP/2 session of a connection, of a server: libnghttp2 with its options and its callbacks,
// which hand headers and data to the connection's streams (session.cc). What it took is
// acknowledged by nghttp2_session_consume. The connection outlives it. Throws std::bad_alloc.
Session NewSession(Connection& connection);

}  // namespace motiondb::server
