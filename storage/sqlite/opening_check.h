// Looks at the files of a store before SQLite opens them, for corruption that SQLite would pass
// over or answer by refusing the whole store. Functions keep no state.
#pragma once

#include <string>
#include <vector>

#include "storage/store_upkeep.h"

namespace motiondb::storage {

struct OpeningCheck {
  std::vector<Damage> found;
  // The log is corrupt: what it holds behind the bad frame is to be removed once the frames before
  // it are recovered.
  bool log_is_corrupt = false;
  // The file ends before its last page, and is still that short.
  bool is_short = false;
};

// Keeps a copy of a corrupt log as `STORE-corrupt-wal`, and fills a store's file that ends too
// early with zeros to its length, so that SQLite serves the pages that are there. A kept copy is
// reported again, until it is deleted. With `read_only` it changes nothing. REQUIRES: the lock of
// the store is held.
OpeningCheck CheckBeforeOpening(const std::string& store_path, bool read_only);

}  // namespace motiondb::storage
