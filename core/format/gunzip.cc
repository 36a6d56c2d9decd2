#include "core/format/gunzip.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "core/format/text_scanner.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

constexpr std::string_view kGzipMember = "\x1f\x8b";
constexpr int kGzipWindow = 16 + MAX_WBITS;  // a gzip header, the largest window
constexpr std::size_t kBlockBytes = std::size_t{1} << 14;

// Whether a file begins as gzip files do.
bool IsGzip(std::string_view bytes) { return bytes.starts_with(kGzipMember); }

class GzipInflater {
 public:
  explicit GzipInflater(SourceFile file) : file_(file) {}
  ~GzipInflater() { inflateEnd(&stream_); }
  GzipInflater(const GzipInflater&) = delete;
  GzipInflater& operator=(const GzipInflater&) = delete;

  absl::Status Run(std::size_t max_bytes) {
    if (inflateInit2(&stream_, kGzipWindow) != Z_OK) return Error("out of memory");
    while (true) {
      if (!file_.bytes.substr(at_).starts_with(kGzipMember)) {
        return Error(at_ == 0 ? "expected a gzip file (1f 8b)"
                              : "expected the end of the file or another gzip member");
      }
      MOTIONDB_RETURN_IF_ERROR(InflateMember(max_bytes));
      if (at_ == file_.bytes.size()) return absl::OkStatus();
      inflateReset(&stream_);
    }
  }

  // After an error, the bytes before it.
  std::string& content() { return content_; }

 private:
  absl::Status InflateMember(std::size_t max_bytes) {
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
      content_.append(block_, 0, block_.size() - stream_.avail_out);
      at_ += input - stream_.avail_in;
      if (content_.size() > max_bytes) {
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
                                 stream_.msg != nullptr ? Shown(stream_.msg) : "unknown"));
      }
    }
  }

  absl::Status Error(std::string_view reason) const {
    return InvalidArgument("{}: byte {}: {}", file_.name, at_, reason);
  }

  SourceFile file_;
  std::size_t at_ = 0;  // of the next compressed byte
  z_stream stream_ = {};
  std::string content_;
  std::string block_ = std::string(kBlockBytes, '\0');
};

}  // namespace

absl::StatusOr<std::string> Gunzip(SourceFile file, std::size_t max_bytes) {
  GzipInflater inflater(file);
  MOTIONDB_RETURN_IF_ERROR(inflater.Run(max_bytes));
  return std::move(inflater.content());
}

absl::StatusOr<SourceFile> PlainFile(SourceFile file, std::size_t max_bytes, std::string& storage) {
  if (!IsGzip(file.bytes)) return file;
  MOTIONDB_ASSIGN_OR_RETURN(storage, Gunzip(file, max_bytes));
  return SourceFile{file.name, storage};
}

std::size_t PlainBytes(std::string_view bytes, std::size_t max_bytes) {
  if (!IsGzip(bytes)) return bytes.size();
  GzipInflater inflater({.name = "", .bytes = bytes});
  inflater.Run(max_bytes).IgnoreError();  // reading the file reports it
  return std::max(bytes.size(), inflater.content().size());
}

}  // namespace motiondb::core
