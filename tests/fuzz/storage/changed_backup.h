// A valid backup with the changes of an input, as a client might send it to be restored. For
// libFuzzer's thread only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace motiondb::tests {

// An input is one byte, whose lowest bit is 1 if the backup gets a valid checksum, then a list of
// changes. Each begins with its kind (1 byte):
//   0 mod 3: place (u32), length (1 byte) and bytes to write there;
//   1 mod 3: as 0, but the place counts only bytes that are not zero;
//   2 mod 3: table, column and row (1 byte each), and a value (kind, length, bytes) to set there.
// All numbers are taken modulo the number of places, tables, columns, rows. Table constraints are
// off.
std::string ChangedBackup(const std::uint8_t* data, std::size_t size);

}  // namespace motiondb::tests
