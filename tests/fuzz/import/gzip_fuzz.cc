// Gzip files. If the first byte is even, the rest is the file. If it is odd, the rest is the
// content of a file with one or more members, which must come out again.
#include <zlib.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "core/format/gunzip.h"
#include "tests/fuzz/support/memory_watch.h"
#include "tests/fuzz/support/properties.h"

using namespace motiondb;

namespace {

constexpr std::size_t kMaxBytes = 1 << 20;

std::string Member(std::string_view content) {
  z_stream stream = {};
  constexpr int kGzip = 16 + MAX_WBITS;
  tests::CheckContract(
      deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, kGzip, 8, Z_DEFAULT_STRATEGY) == Z_OK,
      "zlib has memory");
  std::string member(deflateBound(&stream, content.size()), '\0');
  stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(content.data()));
  stream.avail_in = static_cast<uInt>(content.size());
  stream.next_out = reinterpret_cast<Bytef*>(member.data());
  stream.avail_out = static_cast<uInt>(member.size());
  tests::CheckContract(deflate(&stream, Z_FINISH) == Z_STREAM_END, "zlib compresses");
  member.resize(stream.total_out);
  deflateEnd(&stream);
  return member;
}

// Members of at most `block` bytes of content.
std::string FileOf(std::string_view content, std::size_t block) {
  std::string file = Member(content.substr(0, block));
  for (std::size_t at = block; at < content.size(); at += block) {
    file += Member(content.substr(at, block));
  }
  return file;
}

absl::StatusOr<std::string> Checked(std::string_view file) {
  const tests::MemoryWatch watch;
  auto content = core::Gunzip({"input.gz", file}, kMaxBytes);
  watch.CheckProportional(0, 4 * kMaxBytes, 0);
  tests::CheckErrorContract(content.status(), absl::StatusCode::kInvalidArgument);
  if (!content.ok()) {
    tests::CheckContract(content.status().message().find("input.gz: byte ") == 0,
                         "an error names the file and the byte");
  } else {
    tests::CheckContract(content->size() <= kMaxBytes, "the content is within the limit");
  }
  return content;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view input = tests::AsText(data + 1, size - 1);
  if ((data[0] & 1) == 0) {
    (void)Checked(input);
    return 0;
  }
  // A few members: each costs zlib's memory.
  const std::size_t block = std::max<std::size_t>(1, input.size() / (1 + data[0] / 32));
  const std::string file = FileOf(input, block);
  const auto content = Checked(file);
  tests::CheckContract(content.ok() && *content == input, "the content comes out again");
  tests::CheckContract(!Checked(std::string_view(file).substr(0, file.size() - 1)).ok(),
                       "a truncated file is an error");
  return 0;
}
