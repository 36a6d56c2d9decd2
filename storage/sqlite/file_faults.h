// Faults in the structure of a store's file: pages, tables, indices and references.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// Sets `faults` to the faults as texts: the first 20 of SQLite's integrity check, and rows that
// refer to missing ones. Pages that are not used are no fault. Reads the whole file. DATA_LOSS if
// the check cannot go on; `faults` then has those that it found before.
absl::Status FindFileFaults(Connection& connection, std::vector<std::string>& faults);

}  // namespace motiondb::storage
