// Callbacks of libnghttp2: they pass headers and data to the streams of the connection.
#include <new>
#include <utility>

#include "server/http2/connection.h"

namespace motiondb::server {
namespace {

using Options = std::unique_ptr<nghttp2_option, decltype(&nghttp2_option_del)>;
using Callbacks =
    std::unique_ptr<nghttp2_session_callbacks, decltype(&nghttp2_session_callbacks_del)>;

constexpr int kExemptCalls = 4;  // see CallStream

// Limits on resets by a client: burst size, and rate.
constexpr std::uint64_t kResetBurst = 1000;
constexpr std::uint64_t kResetsPerSecond = 500;

}  // namespace

// Exceptions must not pass through libnghttp2.
struct SessionCallbacks {
  template <typename Work>
  static int CatchBadAlloc(const Work& work) {
    try {
      return work() ? 0 : NGHTTP2_ERR_CALLBACK_FAILURE;
    } catch (const std::bad_alloc&) {
      return NGHTTP2_ERR_CALLBACK_FAILURE;
    }
  }

  static int OnBeginHeaders(nghttp2_session*, const nghttp2_frame* frame, void* user) {
    auto& connection = *static_cast<Connection*>(user);
    if (frame->headers.cat != NGHTTP2_HCAT_REQUEST) return 0;
    return CatchBadAlloc([&] {
      const std::int32_t id = frame->hd.stream_id;
      const bool exempt = connection.streams_.size() < kExemptCalls;
      connection.streams_.emplace(
          id, std::make_shared<CallStream>(connection.bridge_, connection.shared_from_this(), id,
                                           exempt));
      connection.calls_ = static_cast<int>(connection.streams_.size());
      ++connection.calls_begun_;
      return true;
    });
  }

  static int OnHeader(nghttp2_session*, const nghttp2_frame* frame, const std::uint8_t* name,
                      std::size_t name_size, const std::uint8_t* value, std::size_t value_size,
                      std::uint8_t, void* user) {
    if (frame->headers.cat != NGHTTP2_HCAT_REQUEST) return 0;
    CallStream* const stream = static_cast<Connection*>(user)->Find(frame->hd.stream_id);
    const auto text = [](const std::uint8_t* data, std::size_t size) {
      return std::string_view(reinterpret_cast<const char*>(data), size);
    };
    return CatchBadAlloc([&] {
      if (stream == nullptr || stream->AddHeader(text(name, name_size), text(value, value_size))) {
        return true;
      }
      static_cast<Connection*>(user)->End("headers too large");
      return false;
    });
  }

  static int OnFrame(nghttp2_session*, const nghttp2_frame* frame, void* user) {
    auto& connection = *static_cast<Connection*>(user);
    connection.got_frame_ = true;
    const bool is_headers = frame->hd.type == NGHTTP2_HEADERS;
    if (!is_headers && frame->hd.type != NGHTTP2_DATA) return 0;
    return CatchBadAlloc([&] {
      CallStream* const stream = connection.Find(frame->hd.stream_id);
      if (stream == nullptr) return true;
      if (is_headers && frame->headers.cat == NGHTTP2_HCAT_REQUEST) {
        connection.starting_streams_.push_back(stream->shared_from_this());
      }
      if ((frame->hd.flags & NGHTTP2_FLAG_END_STREAM) != 0) stream->EndRequest();
      return true;
    });
  }

  static int OnData(nghttp2_session* session, std::uint8_t, std::int32_t id,
                    const std::uint8_t* data, std::size_t size, void* user) {
    CallStream* const stream = static_cast<Connection*>(user)->Find(id);
    if (stream == nullptr) return nghttp2_session_consume(session, id, size);
    return CatchBadAlloc([&] {
      stream->Receive({data, size});
      return true;
    });
  }

  // After a complete response, RST_STREAM stops a client that still sends. The error text of a sent
  // GOAWAY becomes the logged reason.
  static int OnSent(nghttp2_session* session, const nghttp2_frame* frame, void* user) {
    if (frame->hd.type == NGHTTP2_GOAWAY && frame->goaway.error_code != NGHTTP2_NO_ERROR) {
      return CatchBadAlloc([&] {
        auto& connection = *static_cast<Connection*>(user);
        const nghttp2_goaway& goaway = frame->goaway;
        if (!connection.got_frame_ || !connection.reason_.empty()) return true;
        connection.reason_.assign(goaway.opaque_data, goaway.opaque_data + goaway.opaque_data_len);
        return true;
      });
    }
    const bool is_end =
        frame->hd.type == NGHTTP2_HEADERS && (frame->hd.flags & NGHTTP2_FLAG_END_STREAM) != 0;
    const std::int32_t id = frame->hd.stream_id;
    if (!is_end || nghttp2_session_get_stream_remote_close(session, id) != 0) return 0;
    return nghttp2_submit_rst_stream(session, NGHTTP2_FLAG_NONE, id, NGHTTP2_NO_ERROR);
  }

  static int OnStreamClosed(nghttp2_session*, std::int32_t id, std::uint32_t, void* user) {
    auto& connection = *static_cast<Connection*>(user);
    const auto found = connection.streams_.find(id);
    if (found == connection.streams_.end()) return 0;
    const std::shared_ptr<CallStream> stream = std::move(found->second);
    connection.streams_.erase(found);
    connection.calls_ = static_cast<int>(connection.streams_.size());
    return CatchBadAlloc([&] {
      stream->Detach();
      return true;
    });
  }
};

Session NewSession(Connection& connection) {
  nghttp2_session_callbacks* made = nullptr;
  if (nghttp2_session_callbacks_new(&made) != 0) throw std::bad_alloc();
  const Callbacks callbacks(made, nghttp2_session_callbacks_del);
  using Calls = SessionCallbacks;
  nghttp2_session_callbacks_set_on_begin_headers_callback(made, Calls::OnBeginHeaders);
  nghttp2_session_callbacks_set_on_header_callback(made, Calls::OnHeader);
  nghttp2_session_callbacks_set_on_frame_recv_callback(made, Calls::OnFrame);
  nghttp2_session_callbacks_set_on_data_chunk_recv_callback(made, Calls::OnData);
  nghttp2_session_callbacks_set_on_frame_send_callback(made, Calls::OnSent);
  nghttp2_session_callbacks_set_on_stream_close_callback(made, Calls::OnStreamClosed);

  nghttp2_option* chosen = nullptr;
  if (nghttp2_option_new(&chosen) != 0) throw std::bad_alloc();
  const Options options(chosen, nghttp2_option_del);
  nghttp2_option_set_no_auto_window_update(chosen, 1);
  nghttp2_option_set_no_closed_streams(chosen, 1);
  nghttp2_option_set_stream_reset_rate_limit(chosen, kResetBurst, kResetsPerSecond);

  nghttp2_session* session = nullptr;
  if (nghttp2_session_server_new2(&session, made, &connection, chosen) != 0) throw std::bad_alloc();
  return {session, nghttp2_session_del};
}

}  // namespace motiondb::server
