#include "server/gateway/gzip.h"

#include <zlib.h>

#include <algorithm>
#include <new>

#include "absl/cleanup/cleanup.h"
#include "core/motion/error.h"

namespace motiondb::server {
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

}  // namespace motiondb::server
