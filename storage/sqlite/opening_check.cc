#include "storage/sqlite/opening_check.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

#include "storage/sqlite/store_file.h"

namespace motiondb::storage {
namespace {

constexpr std::uint32_t kLogMagic = 0x377f0682;  // lowest bit 1: checksums of big-endian words
constexpr std::size_t kHeaderBytes = 32;
constexpr std::size_t kFrameHeaderBytes = 24;
constexpr std::size_t kSectorBytes = 512;

// Two consecutive 32-bit numbers: salts or a checksum.
using Pair = std::array<std::uint32_t, 2>;

Pair PairAt(std::string_view bytes, std::size_t place) {
  return {BigEndian(bytes, place), BigEndian(bytes, place + 4)};
}

// Returns the checksum `sum` continued over `bytes`, whose length is a multiple of 8.
Pair Continue(Pair sum, std::string_view bytes, bool big_endian) {
  const auto word = [&](std::size_t place) {
    const std::uint32_t number = BigEndian(bytes, place);
    return big_endian ? number : __builtin_bswap32(number);
  };
  for (std::size_t i = 0; i < bytes.size(); i += 8) {
    sum[0] += word(i) + sum[1];
    sum[1] += word(i + 4) + sum[0];
  }
  return sum;
}

struct LogHeader {
  bool is_good = false;
  bool big_endian = false;
  std::uint32_t page_bytes = 0;
  Pair salts{};
  Pair checksum{};
};

LogHeader ParseHeader(std::string_view bytes) {
  const std::uint32_t magic = BigEndian(bytes, 0);
  LogHeader header{.big_endian = (magic & 1) != 0,
                   .page_bytes = BigEndian(bytes, 8),
                   .salts = PairAt(bytes, 16),
                   .checksum = PairAt(bytes, 24)};
  header.is_good =
      (magic & ~1U) == kLogMagic && header.page_bytes >= 512 && header.page_bytes <= 65536 &&
      std::has_single_bit(header.page_bytes) &&
      Continue({}, bytes.substr(0, kHeaderBytes - 8), header.big_endian) == header.checksum;
  return header;
}

// Checks the frames in order.
class Frames {
 public:
  explicit Frames(const LogHeader& header)
      : header_(header),
        found_bad_(!header.is_good),
        may_be_continued_(header.is_good),
        checksum_(header.checksum),
        salts_(header.salts) {}

  // Checks the next frame; `bytes`: its header and page.
  void Take(std::string_view bytes) {
    ++count_;
    const std::uint32_t page_count = BigEndian(bytes, 4);
    const Pair salts = PairAt(bytes, 8);
    const Pair checksum = PairAt(bytes, 16);
    const bool has_salts = salts == salts_ || (!header_.is_good && !may_be_continued_);
    const bool is_plausible = has_salts && BigEndian(bytes, 0) != 0;
    const bool is_valid = is_plausible && may_be_continued_ && ChecksumOf(bytes) == checksum;
    if (is_valid) {
      TakeValid(page_count);
    } else if (!found_bad_) {
      found_bad_ = true;
      content_.bad_frame = count_;
    }
    may_be_continued_ = is_plausible;
    checksum_ = checksum;
    if (!header_.is_good) salts_ = salts;
    ends_transaction_ = page_count != 0 && (is_valid || IsInOneSector());
  }

  const LogContent& content() const { return content_; }

 private:
  Pair ChecksumOf(std::string_view frame) const {
    const Pair begun = Continue(checksum_, frame.substr(0, 8), header_.big_endian);
    return Continue(begun, frame.substr(kFrameHeaderBytes), header_.big_endian);
  }

  void TakeValid(std::uint32_t page_count) {
    if (!found_bad_) {
      if (page_count != 0) content_.page_count = page_count;
      return;
    }
    ++content_.lost_frames;
    if (page_count != 0) ++content_.lost_transactions;
    content_.is_corrupt = content_.is_corrupt || ends_transaction_;
  }

  // Returns whether the page count and the salts of this frame are in one sector, which a disk
  // writes as a whole.
  bool IsInOneSector() const {
    const std::size_t begin = kHeaderBytes + static_cast<std::size_t>(count_ - 1) *
                                                 (kFrameHeaderBytes + header_.page_bytes);
    return begin / kSectorBytes == (begin + 15) / kSectorBytes;
  }

  const LogHeader header_;
  LogContent content_;
  std::int64_t count_ = 0;
  bool found_bad_;
  // The previous frame: whether its checksum may be continued, its checksum, its salts, and whether
  // it ends a transaction.
  bool may_be_continued_;
  Pair checksum_;
  Pair salts_;
  bool ends_transaction_ = false;
};

LogContent ReadFrames(std::ifstream& file, const LogHeader& header) {
  Frames frames(header);
  std::string frame(kFrameHeaderBytes + header.page_bytes, '\0');
  file.clear();
  file.seekg(kHeaderBytes);
  while (file.read(frame.data(), static_cast<std::streamsize>(frame.size()))) frames.Take(frame);
  return frames.content();
}

}  // namespace

LogContent ReadLog(const std::string& path, std::uint32_t page_bytes) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes(kHeaderBytes, '\0');
  if (!file.read(bytes.data(), kHeaderBytes)) return {};
  LogHeader header = ParseHeader(bytes);
  if (header.is_good) return ReadFrames(file, header);
  if (page_bytes < 512 || !std::has_single_bit(page_bytes)) return {};
  // Recovery treats a log with a bad header as empty. Try both byte orders of the checksums.
  header.page_bytes = page_bytes;
  header.big_endian = false;
  const LogContent little = ReadFrames(file, header);
  header.big_endian = true;
  const LogContent big = ReadFrames(file, header);
  return little.lost_frames > big.lost_frames ? little : big;
}

namespace {

namespace fs = std::filesystem;

std::string Describe(const LogContent& log, const std::string& path) {
  const std::string where =
      log.bad_frame == 0 ? "its header" : fmt::format("its frame {}", log.bad_frame);
  return fmt::format(
      "the log '{}' is corrupt at {}: SQLite drops {} valid frames after it, with {} complete "
      "transactions; acknowledged changes may be missing",
      path, where, log.lost_frames, log.lost_transactions);
}

void CheckLog(const std::string& store_path, std::uint32_t page_bytes, bool read_only,
              OpeningCheck& check, LogContent& log) {
  const std::string path = LogPath(store_path);
  const std::string kept_path = store_path + "-corrupt-wal";
  log = ReadLog(path, page_bytes);
  check.log_is_corrupt = log.is_corrupt;
  std::error_code error;
  if (log.is_corrupt && !read_only) {
    fs::copy_file(path, kept_path, fs::copy_options::overwrite_existing, error);
  }
  const LogContent kept = ReadLog(kept_path, page_bytes);
  if (kept.is_corrupt && !error) {
    check.found.push_back(
        {"", fmt::format("{}; ingest missing clips again or restore a backup, then delete '{}', "
                         "the copy of that log",
                         Describe(kept, path), kept_path)});
  } else if (log.is_corrupt) {
    check.found.push_back({"", Describe(log, path)});
  }
}

// Checks whether the file was truncated. REQUIRES: recovery finds nothing in the log.
void CheckLength(const std::string& path, std::string_view header, std::int64_t page_bytes,
                 bool read_only, OpeningCheck& check) {
  // SQLite ignores the page count if the last writer did not update it.
  constexpr std::size_t kChangeCounter = 24;
  constexpr std::size_t kPageCount = 28;
  constexpr std::size_t kCountIsOfChange = 92;
  if (BigEndian(header, kChangeCounter) != BigEndian(header, kCountIsOfChange)) return;
  std::error_code error;
  // Creation of the store was interrupted: SQLite rolls it back.
  if (fs::exists(path + "-journal", error)) return;
  const auto bytes = static_cast<std::int64_t>(fs::file_size(path, error));
  const std::int64_t expected = BigEndian(header, kPageCount) * page_bytes;
  if (error || bytes < page_bytes || bytes >= expected) return;
  check.found.push_back(
      {"", fmt::format("the file '{}' was truncated: expected {} bytes, got {}; the data on its "
                       "last {} pages is lost: restore a backup",
                       path, expected, bytes, (expected - bytes + page_bytes - 1) / page_bytes)});
  if (!read_only) fs::resize_file(path, static_cast<std::uintmax_t>(expected), error);
  check.is_short = read_only || error;
}

}  // namespace

OpeningCheck CheckBeforeOpening(const std::string& store_path, bool read_only) {
  OpeningCheck check;
  std::string header(kStoreHeaderBytes, '\0');
  std::ifstream stream(store_path, std::ios::binary);
  if (!stream.read(header.data(), static_cast<std::streamsize>(header.size()))) return check;
  const std::uint32_t field = BigEndian(header, 14) & 0xffff;
  const std::uint32_t page_bytes = field == 1 ? 65536 : field;
  LogContent log;
  CheckLog(store_path, page_bytes, read_only, check, log);
  if (log.page_count == 0) CheckLength(store_path, header, page_bytes, read_only, check);
  return check;
}

}  // namespace motiondb::storage
