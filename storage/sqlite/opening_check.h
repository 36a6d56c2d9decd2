// Checks the files of a store before SQLite opens them, for corruption that SQLite would ignore or
// because of which it would refuse the whole store.
#pragma once

#include <string>
#include <vector>

#include "storage/store_maintenance.h"

namespace motiondb::storage {

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
