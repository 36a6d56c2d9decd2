// Reads SQLite's write-ahead log as recovery does
// (https://www.sqlite.org/fileformat2.html#walformat) and tells a torn end, which a power cut
// leaves, from corruption. Functions keep no state and change no file.
//
// The log is a header of 32 bytes and frames of 24 bytes and a page each. The checksum of a frame
// continues that of the frame before it. Recovery stops at the first frame whose salts or checksum
// are wrong and drops all that follows it.
//
// After that frame, a frame is valid if its salts are the header's, its page number is not 0, and
// its checksum continues the checksum that the frame before it has stored. Valid frames alone are
// no corruption: a power cut may keep any sectors of the transaction that was being written, and
// what a failed or torn transaction left is overwritten only in part. But a valid frame directly
// after the last frame of a transaction (its commit frame) is of a later transaction, and SQLite
// begins that only when the former one is synced. So the log is corrupt if there is such a pair at
// or after the first bad frame. A bad frame in the very last transaction cannot be told from a torn
// one and is not corruption here.
#pragma once

#include <cstdint>
#include <string>

namespace motiondb::storage {

struct LogContent {
  // Pages of the store after the last transaction that recovery finds; 0: it finds none.
  std::int64_t page_count = 0;
  bool is_corrupt = false;
  // Where it is corrupt: the first bad frame, counted from 1, or 0 for the header; the valid frames
  // after that, and how many transactions end with one of them.
  std::int64_t bad_frame = 0;
  std::int64_t lost_frames = 0;
  std::int64_t lost_transactions = 0;
};

// A log that is not there, or cannot be read, is empty: SQLite reports what is wrong with it.
// `page_bytes`, the store's, is needed where the log's header is bad.
LogContent ReadLog(const std::string& path, std::uint32_t page_bytes);

}  // namespace motiondb::storage
