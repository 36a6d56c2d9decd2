#include "server/gateway/http_content.h"

#include <zlib.h>

#include <algorithm>
#include <new>

#include "absl/cleanup/cleanup.h"
#include "core/motion/error.h"
#include "server/http2/grpc_wire.h"
#include "text/utf8.h"

namespace motiondb::server {

std::string_view Trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return "";
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

std::string_view TakeItem(std::string_view& list, char separator) {
  const auto end = std::min(list.find(separator), list.size());
  const std::string_view item = list.substr(0, end);
  list.remove_prefix(std::min(end + 1, list.size()));
  return Trimmed(item);
}

bool AcceptsGzip(std::string_view list) {
  while (!list.empty()) {
    const std::string item = text::LowerCase(TakeItem(list, ','));
    const auto semicolon = std::min(item.find(';'), item.size());
    if (Trimmed(std::string_view(item).substr(0, semicolon)) != "gzip") continue;
    const auto quality = item.find("q=", semicolon);
    return quality == std::string::npos ||
           item.find_first_of("123456789", quality) != std::string::npos;
  }
  return false;
}

namespace {

constexpr int kGzipWindowBits = 15 + 16;
constexpr std::size_t kFirstBytes = 4 << 10;
constexpr std::size_t kMaxStepBytes = 256 << 10;

// zlib takes non-const input, which it does not change.
void SetInput(z_stream& stream, std::string_view bytes) {
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
}

}  // namespace

absl::StatusOr<std::string> Gunzip(std::string_view bytes,
                                   const std::function<absl::Status(std::int64_t)>& admit) {
  z_stream stream{};
  if (inflateInit2(&stream, kGzipWindowBits) != Z_OK) throw std::bad_alloc();
  const absl::Cleanup end = [&] { inflateEnd(&stream); };
  SetInput(stream, bytes);
  std::string content;
  int result = Z_OK;
  while (result == Z_OK) {
    const std::size_t used = content.size();
    const std::size_t more = std::clamp(used, kFirstBytes, kMaxStepBytes);
    MOTIONDB_RETURN_IF_ERROR(admit(static_cast<std::int64_t>(used + more)));
    content.resize(used + more);
    stream.next_out = reinterpret_cast<Bytef*>(content.data() + used);
    stream.avail_out = static_cast<uInt>(more);
    result = inflate(&stream, Z_NO_FLUSH);
    content.resize(content.size() - stream.avail_out);
  }
  if (result == Z_MEM_ERROR) throw std::bad_alloc();
  if (result == Z_STREAM_END && stream.avail_in == 0) return content;
  return core::InvalidArgument("expected gzip data: {}", result == Z_STREAM_END
                                                             ? "bytes follow its end"
                                                         : result == Z_BUF_ERROR ? "it is truncated"
                                                                                 : "it is corrupt");
}

std::string Gzip(std::string_view bytes) {
  z_stream stream{};
  if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, kGzipWindowBits, 8, Z_DEFAULT_STRATEGY) !=
      Z_OK) {
    throw std::bad_alloc();
  }
  const absl::Cleanup end = [&] { deflateEnd(&stream); };
  SetInput(stream, bytes);
  std::string compressed(deflateBound(&stream, static_cast<uLong>(bytes.size())), '\0');
  stream.next_out = reinterpret_cast<Bytef*>(compressed.data());
  stream.avail_out = static_cast<uInt>(compressed.size());
  deflate(&stream, Z_FINISH);  // fits by deflateBound
  compressed.resize(stream.total_out);
  return compressed;
}

absl::StatusOr<Envelope> ParseEnvelope(std::string_view body) {
  if (body.empty()) return core::InvalidArgument("expected one request message, got none");
  if (body.size() < kMessagePrefixBytes) {
    return core::InvalidArgument("expected an envelope of at least {} bytes, got {}",
                                 kMessagePrefixBytes, body.size());
  }
  MessagePrefix prefix;
  for (std::size_t i = 0; i < prefix.size(); ++i) prefix[i] = static_cast<std::uint8_t>(body[i]);
  if ((prefix[0] & ~kCompressed) != 0) {
    return core::InvalidArgument("envelope: expected flags 0 or 1, got {}", prefix[0]);
  }
  const std::uint32_t length = MessageLength(prefix);
  body.remove_prefix(kMessagePrefixBytes);
  if (body.size() < length) {
    return core::InvalidArgument("envelope: expected {} bytes, got {}", length, body.size());
  }
  if (body.size() > length) {
    return core::InvalidArgument("expected one request message; {} bytes follow it",
                                 body.size() - length);
  }
  return Envelope{.compressed = prefix[0] == kCompressed, .message = body};
}

std::string MakeEnvelope(std::uint8_t flags, std::string_view message) {
  MessagePrefix prefix = MakeMessagePrefix(static_cast<std::uint32_t>(message.size()));
  prefix[0] = flags;
  std::string envelope(reinterpret_cast<const char*>(prefix.data()), prefix.size());
  return envelope.append(message);
}

}  // namespace motiondb::server
