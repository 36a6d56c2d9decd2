#include "server/http2/connection.h"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio/post.hpp>
#include <cerrno>
#include <new>
#include <utility>

namespace motiondb::server {

namespace {

constexpr std::chrono::seconds kFirstFrameTime{20};  // for the TLS handshake and the first frame
constexpr std::chrono::seconds kIdleToPing{60};      // idle time before a ping
constexpr std::chrono::seconds kPingReplyTime{20};
constexpr std::size_t kChunkBytes = 64 << 10;  // maximum of one read or write
// Size of a read in which calls begin: at most about 200 calls before other connections have a
// turn.
constexpr std::size_t kSmallChunkBytes = 4 << 10;
constexpr int kChunksPerTurn = 4;
constexpr std::chrono::seconds kClientCloseTime{
    1};  // for the client to close after the server's end
constexpr std::int64_t kMaxDroppedBytes = 4 << 20;

// Flow-control windows for received data, bytes.
constexpr std::uint32_t kStreamWindow = 1 << 20;
constexpr std::int32_t kConnectionWindow = 4 << 20;

std::span<std::uint8_t> Buffer() {
  static thread_local std::array<std::uint8_t, kChunkBytes> buffer;
  return buffer;
}

}  // namespace

Connection::Connection(CallBridge& bridge, AcceptedClient client)
    : bridge_(bridge),
      context_(client.context),
      work_(client.context.get_executor()),
      bytes_(std::move(client.bytes)),
      peer_(std::move(client.peer)),
      on_closed_(std::move(client.on_closed)),
      session_(NewSession(*this)) {}

Connection::~Connection() = default;

void Connection::Start() {
  const CallLimitOptions& limits = bridge_.limits.options();
  const std::array settings = {
      nghttp2_settings_entry{NGHTTP2_SETTINGS_MAX_CONCURRENT_STREAMS,
                             static_cast<std::uint32_t>(limits.calls.per_client)},
      nghttp2_settings_entry{NGHTTP2_SETTINGS_INITIAL_WINDOW_SIZE, kStreamWindow},
      nghttp2_settings_entry{NGHTTP2_SETTINGS_MAX_HEADER_LIST_SIZE,
                             4 * static_cast<std::uint32_t>(limits.max_metadata_bytes)}};
  nghttp2_submit_settings(session_.get(), NGHTTP2_FLAG_NONE, settings.data(), settings.size());
  nghttp2_session_set_local_window_size(session_.get(), NGHTTP2_FLAG_NONE, 0, kConnectionWindow);
  Serve();
}

void Connection::Post(std::function<void()> work) {
  boost::asio::post(context_, [self = shared_from_this(), work = std::move(work)] {
    work();
    self->FlushSoon();
  });
}

// Posts one write for the output of this and further work. It does not read: otherwise a client
// with short calls would have more turns than others.
void Connection::FlushSoon() {
  if (closed_ || std::exchange(flushing_, true)) return;
  boost::asio::post(context_, [self = shared_from_this()] {
    self->flushing_ = false;
    self->Serve(Turn::kWrite);
  });
}

CallStream* Connection::Find(std::int32_t id) {
  const auto found = streams_.find(id);
  return found == streams_.end() ? nullptr : found->second.get();
}

// Queues a GOAWAY; the caller then closes the connection.
void Connection::End(const char* reason) {
  reason_ = reason;
  nghttp2_session_terminate_session(session_.get(), NGHTTP2_ENHANCE_YOUR_CALM);
}

void Connection::Serve(Turn turn) {
  if (closed_ || serving_) return;
  if (closing_since_.has_value()) return DropInput();
  serving_ = true;
  const auto self = shared_from_this();
  bool open = true;
  try {
    open = WriteSome() && (turn == Turn::kWrite || (ReadSome() && WriteSome()));
  } catch (const std::bad_alloc&) {
    reason_ = "out of memory";
    open = false;
  }
  serving_ = false;
  const bool is_done = nghttp2_session_want_read(session_.get()) == 0 &&
                       nghttp2_session_want_write(session_.get()) == 0 && unsent_.empty();
  if (!open || is_done) Leave();
  if (!closed_) Await();
}

// Stops sending. Input is read and dropped until the client closes: closing a socket with unread
// bytes resets it, and the client could lose the last output.
void Connection::Leave() {
  if (closed_ || closing_since_.has_value()) return;
  closing_since_ = Clock::now();
  DetachStreams();
  unsent_.clear();
  bytes_.EndWriting();
}

void Connection::DetachStreams() {
  for (const auto& [id, stream] : streams_) stream->Detach();
  streams_.clear();
  starting_streams_.clear();  // they refer to the connection
  calls_ = 0;
}

void Connection::DropInput() {
  for (int i = 0; i < kChunksPerTurn; ++i) {
    const ssize_t size = recv(bytes_.socket().native_handle(), Buffer().data(), kChunkBytes, 0);
    const bool is_open = size > 0 || (size < 0 && (errno == EAGAIN || errno == EINTR));
    dropped_ += std::max<ssize_t>(size, 0);
    if (!is_open || dropped_ > kMaxDroppedBytes) return Close();
    if (size < 0) break;
  }
  Await();
}

// Reads available input, at most kChunksPerTurn. False: the connection has ended.
bool Connection::ReadSome() {
  for (int i = 0; i < kChunksPerTurn && unsent_.empty(); ++i) {
    const std::span<std::uint8_t> buffer = Buffer().first(chunk_);
    const std::size_t kept_bytes = frames_.Resume(buffer);
    const ByteStream::Result read = bytes_.Read(buffer.subspan(kept_bytes));
    wants_write_ = read.outcome == ByteStream::Outcome::kWantsWrite;
    if (read.outcome == ByteStream::Outcome::kClosed) return false;
    if (read.outcome != ByteStream::Outcome::kDone) return true;
    if (!got_frame_ && common_name_.empty()) common_name_ = bytes_.CommonName();
    last_activity_ = Clock::now();
    pinged_ = false;
    const std::size_t passed = frames_.Pass(buffer.first(kept_bytes + read.bytes));
    const std::int64_t begun = calls_begun_;
    ssize_t taken = 0;
    if (frames_.TooMany(last_activity_)) {
      End("too many frames without a call");
      taken = NGHTTP2_ERR_FLOODED;
    } else {
      taken = nghttp2_session_mem_recv(session_.get(), buffer.data(), passed);
    }
    if (taken < 0) {
      if (reason_.empty() && got_frame_) reason_ = nghttp2_strerror(static_cast<int>(taken));
      WriteSome();  // sends the GOAWAY with the reason
      return false;
    }
    const auto beginning = std::exchange(starting_streams_, {});
    for (const auto& stream : beginning) stream->Begin();
    const bool is_bulk = read.bytes >= kSmallChunkBytes && calls_begun_ == begun;
    chunk_ = is_bulk ? kChunkBytes : kSmallChunkBytes;
    if (!is_bulk) return true;
    if (!WriteSome()) return false;
  }
  return true;
}

// Writes output until none is left or the socket accepts no more. False: the connection has ended.
bool Connection::WriteSome() {
  while (true) {
    if (unsent_.empty()) {
      const std::span<std::uint8_t> buffer = Buffer();
      std::size_t size = 0;
      while (size < buffer.size()) {
        const std::uint8_t* data = nullptr;
        const ssize_t made = nghttp2_session_mem_send(session_.get(), &data);
        if (made < 0) return false;
        if (made == 0) break;
        const auto bytes = static_cast<std::size_t>(made);
        const std::size_t fits = std::min(bytes, buffer.size() - size);
        std::copy_n(data, fits, buffer.data() + size);
        size += fits;
        unsent_.insert(unsent_.end(), data + fits, data + bytes);  // rest of the last frame
      }
      if (size == 0) return true;
      std::size_t written = 0;
      while (written < size) {
        const ByteStream::Result result = bytes_.Write(buffer.subspan(written, size - written));
        if (result.outcome == ByteStream::Outcome::kClosed) return false;
        if (result.outcome != ByteStream::Outcome::kDone) break;
        written += result.bytes;
        last_activity_ = Clock::now();
      }
      unsent_.insert(unsent_.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(written),
                     buffer.begin() + static_cast<std::ptrdiff_t>(size));
    }
    while (!unsent_.empty()) {
      const ByteStream::Result result = bytes_.Write(unsent_);
      if (result.outcome == ByteStream::Outcome::kClosed) return false;
      if (result.outcome != ByteStream::Outcome::kDone) return true;
      last_activity_ = Clock::now();
      unsent_.erase(unsent_.begin(), unsent_.begin() + static_cast<std::ptrdiff_t>(result.bytes));
    }
    if (unsent_.capacity() > 0) std::vector<std::uint8_t>().swap(unsent_);
  }
}

void Connection::Await() {
  using Socket = boost::asio::ip::tcp::socket;
  // A client that does not read gets no further reads.
  if (unsent_.empty() && !closing_since_.has_value() && bytes_.HasPending()) {
    boost::asio::post(context_, [self = shared_from_this()] { self->Serve(); });
  } else if (unsent_.empty() && !std::exchange(awaiting_read_, true)) {
    bytes_.socket().async_wait(Socket::wait_read, [self = shared_from_this()](auto) {
      self->awaiting_read_ = false;
      self->Serve();
    });
  }
  if ((!unsent_.empty() || wants_write_) && !std::exchange(awaiting_write_, true)) {
    bytes_.socket().async_wait(Socket::wait_write, [self = shared_from_this()](auto) {
      self->awaiting_write_ = false;
      self->Serve();
    });
  }
}

void Connection::Tick(Clock::time_point now) {
  if (closed_) return;
  if (closing_since_.has_value()) {
    if (now - *closing_since_ > kClientCloseTime) Close();
    return;
  }
  if (!got_frame_ && now - began() > kFirstFrameTime) return Close();
  if (now - last_activity_ > kIdleToPing + kPingReplyTime) return Close();
  if (now - last_activity_ > kIdleToPing && got_frame_ && !std::exchange(pinged_, true)) {
    nghttp2_submit_ping(session_.get(), NGHTTP2_FLAG_NONE, nullptr);
  }
  for (const auto& [id, stream] : streams_) stream->Tick(now);
  Serve();
}

void Connection::BeginDrain() {
  if (closed_ || closing_since_.has_value()) return;
  nghttp2_submit_shutdown_notice(session_.get());
  Serve();
}

void Connection::Drain() {
  draining_ = true;
  if (closed_ || closing_since_.has_value()) return;
  nghttp2_submit_goaway(session_.get(), NGHTTP2_FLAG_NONE,
                        nghttp2_session_get_last_proc_stream_id(session_.get()), NGHTTP2_NO_ERROR,
                        nullptr, 0);
  Serve();
}

void Connection::Close() {
  if (std::exchange(closed_, true)) return;
  DetachStreams();
  bytes_.Close();
  on_closed_(shared_from_this(), reason_);
}

}  // namespace motiondb::server
