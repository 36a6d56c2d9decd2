#include "import/gunzip.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <limits>
#include <string>
#include <string_view>

#include "core/format/text_scanner.h"
#include "core/motion/error.h"

namespace motiondb::importer {
namespace {

constexpr std::string_view kGzipMember = "\x1f\x8b";
constexpr int kGzipWindow = 16 + MAX_WBITS;  // a gzip header, the largest window
constexpr std::size_t kGunzipBytes = std::size_t{1} << 18;

class GzipInflater {
 public:
  explicit GzipInflater(core::SourceFile file) : file_(file) {}
  ~GzipInflater() { inflateEnd(&stream_); }
  GzipInflater(const GzipInflater&) = delete;
  GzipInflater& operator=(const GzipInflater&) = delete;

  absl::StatusOr<std::string> Run(std::size_t max_bytes) {
    if (inflateInit2(&stream_, kGzipWindow) != Z_OK) return Error("out of memory");
    std::string content;
    while (true) {
      if (!file_.bytes.substr(at_).starts_with(kGzipMember)) {
        return Error(at_ == 0 ? "expected a gzip file (1f 8b)"
                              : "expected the end of the file or another gzip member");
      }
      MOTIONDB_RETURN_IF_ERROR(InflateMember(max_bytes, content));
      if (at_ == file_.bytes.size()) return content;
      inflateReset(&stream_);
    }
  }

 private:
  absl::Status InflateMember(std::size_t max_bytes, std::string& content) {
    while (true) {
      const std::size_t input =
          std::min<std::size_t>(file_.bytes.size() - at_, std::numeric_limits<uInt>::max());
      // zlib does not write to its input.
      stream_.next_in =
          const_cast<Bytef*>(reinterpret_cast<const Bytef*>(file_.bytes.data() + at_));
      stream_.avail_in = static_cast<uInt>(input);
      stream_.next_out = reinterpret_cast<Bytef*>(block_.data());
      stream_.avail_out = static_cast<uInt>(block_.size());
      const int result = inflate(&stream_, Z_NO_FLUSH);
      content.append(block_, 0, block_.size() - stream_.avail_out);
      at_ += input - stream_.avail_in;
      if (content.size() > max_bytes) {
        return Error(fmt::format("more than {} decompressed bytes", max_bytes));
      }
      if (result == Z_STREAM_END) return absl::OkStatus();
      if (result == Z_BUF_ERROR ||
          (result == Z_OK && at_ == file_.bytes.size() && stream_.avail_out > 0)) {
        return Error("the file ends inside a gzip member (truncated?)");
      }
      if (result == Z_MEM_ERROR) return Error("out of memory");
      if (result != Z_OK) {
        return Error(fmt::format("corrupt gzip data: {}",
                                 stream_.msg != nullptr ? core::Shown(stream_.msg) : "unknown"));
      }
    }
  }

  absl::Status Error(std::string_view reason) const {
    return core::InvalidArgument("{}: byte {}: {}", file_.name, at_, reason);
  }

  core::SourceFile file_;
  std::size_t at_ = 0;  // of the next compressed byte
  z_stream stream_ = {};
  std::string block_ = std::string(kGunzipBytes, '\0');
};

}  // namespace

absl::StatusOr<std::string> Gunzip(core::SourceFile file, std::size_t max_bytes) {
  return GzipInflater(file).Run(max_bytes);
}

}  // namespace motiondb::importer
