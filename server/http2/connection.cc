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

constexpr std::chrono::seconds kGreetingTime{20};  // for the TLS handshake and the first frame
constexpr std::chrono::seconds kSilenceToPing{
    60};  // after which the client is asked whether it is there
constexpr std::chrono::seconds kPingTime{20};  // for its answer
constexpr std::size_t kChunk = 64 << 10;       // read or written at a time, at most
// Read at a time where calls begin: at most some 200 of them before other connections have a turn.
constexpr std::size_t kSmallChunk = 4 << 10;
constexpr int kChunksInTurn = 4;
constexpr std::chrono::seconds kLeavingTime{1};  // for a client to close, once it was told to
constexpr std::int64_t kMostDropped = 4 << 20;

// The windows for what a client sends: of a stream, and of all of a connection.
constexpr std::uint32_t kStreamWindow = 1 << 20;
constexpr std::int32_t kConnectionWindow = 4 << 20;

std::span<std::uint8_t> Buffer() {
  static thread_local std::array<std::uint8_t, kChunk> buffer;
  return buffer;
}

}  // namespace

Connection::Connection(CallBridge& bridge, boost::asio::io_context& context, ByteStream bytes,
                       std::string peer, OnClosed on_closed)
    : bridge_(bridge),
      context_(context),
      work_(context.get_executor()),
      bytes_(std::move(bytes)),
      peer_(std::move(peer)),
      on_closed_(std::move(on_closed)),
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

// Sends what this and further pieces of work have to send, in one go. Does not read: else a client
// whose calls end quickly would have more turns than others.
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

// Tells the client to go; the caller closes the connection then.
void Connection::End(const char* reason) {
  reason_ = reason;
  nghttp2_session_terminate_session(session_.get(), NGHTTP2_ENHANCE_YOUR_CALM);
}

void Connection::Serve(Turn turn) {
  if (closed_ || serving_) return;
  if (leaving_.has_value()) return DropInput();
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
  const bool over = nghttp2_session_want_read(session_.get()) == 0 &&
                    nghttp2_session_want_write(session_.get()) == 0 && unsent_.empty();
  if (!open || over) Leave();
  if (!closed_) Await();
}

// No more is sent. What still comes is read and dropped until the client closes, too: closing a
// socket with unread bytes could take from the client what it was told last.
void Connection::Leave() {
  if (closed_ || leaving_.has_value()) return;
  leaving_ = Clock::now();
  LetGoOfStreams();
  unsent_.clear();
  bytes_.EndWriting();
}

void Connection::LetGoOfStreams() {
  for (const auto& [id, stream] : streams_) stream->Detach();
  streams_.clear();
  beginning_.clear();  // they keep the connection, too
  calls_ = 0;
}

void Connection::DropInput() {
  for (int i = 0; i < kChunksInTurn; ++i) {
    const ssize_t size = recv(bytes_.socket().native_handle(), Buffer().data(), kChunk, 0);
    const bool is_open = size > 0 || (size < 0 && (errno == EAGAIN || errno == EINTR));
    dropped_ += std::max<ssize_t>(size, 0);
    if (!is_open || dropped_ > kMostDropped) return Close();
    if (size < 0) break;
  }
  Await();
}

// False: the connection is over. Reads what has come, within its turn.
bool Connection::ReadSome() {
  for (int i = 0; i < kChunksInTurn && unsent_.empty(); ++i) {
    const std::span<std::uint8_t> buffer = Buffer().first(chunk_);
    const std::size_t kept = frames_.Resume(buffer);
    const ByteStream::Result read = bytes_.Read(buffer.subspan(kept));
    wants_write_ = read.outcome == ByteStream::Outcome::kWantsWrite;
    if (read.outcome == ByteStream::Outcome::kClosed) return false;
    if (read.outcome != ByteStream::Outcome::kDone) return true;
    if (!greeted_ && common_name_.empty()) common_name_ = bytes_.CommonName();
    heard_ = Clock::now();
    pinged_ = false;
    const std::size_t passed = frames_.Pass(buffer.first(kept + read.bytes));
    const std::int64_t begun = calls_begun_;
    ssize_t taken = 0;
    if (frames_.TooMany(heard_)) {
      End("too many frames without a call");
      taken = NGHTTP2_ERR_FLOODED;
    } else {
      taken = nghttp2_session_mem_recv(session_.get(), buffer.data(), passed);
    }
    if (taken < 0) {
      if (reason_.empty() && greeted_) reason_ = nghttp2_strerror(static_cast<int>(taken));
      WriteSome();  // tells the client why, if it still listens
      return false;
    }
    const auto beginning = std::exchange(beginning_, {});
    for (const auto& stream : beginning) stream->Begin();
    const bool is_bulk = read.bytes >= kSmallChunk && calls_begun_ == begun;
    chunk_ = is_bulk ? kChunk : kSmallChunk;
    if (!is_bulk) return true;
    if (!WriteSome()) return false;
  }
  return true;
}

// False: the connection is over. Writes what there is until the socket takes no more.
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
        unsent_.insert(unsent_.end(), data + fits, data + bytes);  // of the last frame
      }
      if (size == 0) return true;
      std::size_t written = 0;
      while (written < size) {
        const ByteStream::Result result = bytes_.Write(buffer.subspan(written, size - written));
        if (result.outcome == ByteStream::Outcome::kClosed) return false;
        if (result.outcome != ByteStream::Outcome::kDone) break;
        written += result.bytes;
        heard_ = Clock::now();
      }
      unsent_.insert(unsent_.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(written),
                     buffer.begin() + static_cast<std::ptrdiff_t>(size));
    }
    while (!unsent_.empty()) {
      const ByteStream::Result result = bytes_.Write(unsent_);
      if (result.outcome == ByteStream::Outcome::kClosed) return false;
      if (result.outcome != ByteStream::Outcome::kDone) return true;
      heard_ = Clock::now();
      unsent_.erase(unsent_.begin(), unsent_.begin() + static_cast<std::ptrdiff_t>(result.bytes));
    }
    if (unsent_.capacity() > 0) std::vector<std::uint8_t>().swap(unsent_);
  }
}

void Connection::Await() {
  using Socket = boost::asio::ip::tcp::socket;
  // Nothing more is read from a client that takes nothing.
  if (unsent_.empty() && !leaving_.has_value() && bytes_.HasPending()) {
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
  if (leaving_.has_value()) {
    if (now - *leaving_ > kLeavingTime) Close();
    return;
  }
  if (!greeted_ && now - began_ > kGreetingTime) return Close();
  if (now - heard_ > kSilenceToPing + kPingTime) return Close();
  if (now - heard_ > kSilenceToPing && greeted_ && !std::exchange(pinged_, true)) {
    nghttp2_submit_ping(session_.get(), NGHTTP2_FLAG_NONE, nullptr);
  }
  for (const auto& [id, stream] : streams_) stream->Tick(now);
  Serve();
}

void Connection::Drain() {
  draining_ = true;
  if (closed_ || leaving_.has_value()) return;
  nghttp2_submit_goaway(session_.get(), NGHTTP2_FLAG_NONE,
                        nghttp2_session_get_last_proc_stream_id(session_.get()), NGHTTP2_NO_ERROR,
                        nullptr, 0);
  Serve();
}

void Connection::Close() {
  if (std::exchange(closed_, true)) return;
  LetGoOfStreams();
  bytes_.Close();
  on_closed_(shared_from_this(), reason_);
}

}  // namespace motiondb::server
