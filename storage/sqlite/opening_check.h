// Checks the files of a store before SQLite opens them, for corruption that SQLite would ignore or
// because of which it would refuse the whole store.
//
// SQLite's write-ahead log (https://www.sqlite.org/fileformat2.html#walformat) consists of a header
// of 32 bytes and of frames: a frame header of 24 bytes and a page. The checksum of a frame
// continues the checksum of the frame before it. Recovery stops at the first bad frame (wrong salts
// or checksum) and drops the rest of the log.
//
// After the first bad frame, a frame is valid if its salts are those of the header, its page number
// is not 0, and its checksum continues the stored checksum of the frame before it. Valid frames
// alone do not prove corruption: a power cut may keep any sectors of the last transaction, and the
// rest of a failed transaction is overwritten only in part. But a valid frame directly after a
// commit frame (the last of a transaction) belongs to a later transaction, which SQLite begins only
// after the former one is synced. So the log is corrupt if there is such a pair at or after the
// first bad frame. A bad frame in the last transaction looks like an incomplete write and is not
// reported.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "storage/store_maintenance.h"

namespace motiondb::storage {

// What ReadLog finds.
struct LogContent {
  // Page count of the store after the last transaction that recovery finds; 0: it finds none.
  std::int64_t page_count = 0;
  bool is_corrupt = false;
  // If corrupt: the first bad frame, counted from 1 (0: the header); the number of valid frames
  // after it; and the number of commit frames among those.
  std::int64_t bad_frame = 0;
  std::int64_t lost_frames = 0;
  std::int64_t lost_transactions = 0;
};

// Reads the log as recovery does, and distinguishes corruption from an incomplete end after a power
// cut. Changes no file. Returns an empty result if the log does not exist or cannot be read: SQLite
// reports such errors. `page_bytes`: page size of the store, used if the header of the log is bad.
LogContent ReadLog(const std::string& path, std::uint32_t page_bytes);

struct OpeningCheck {
  std::vector<Corruption> found;
  // The log is corrupt: after recovery of the frames before the bad frame, empty it.
  bool log_is_corrupt = false;
  // The file ends before its last page and was not extended.
  bool is_short = false;
};

// Copies a corrupt log to `STORE-corrupt-wal`; the copy is reported at each opening until it is
// deleted. Extends a truncated store file with zeros to its length, so that SQLite serves the
// remaining pages. With `read_only` it changes nothing. REQUIRES: the caller holds the StoreLock.
OpeningCheck CheckBeforeOpening(const std::string& store_path, bool read_only);

}  // namespace motiondb::storage
