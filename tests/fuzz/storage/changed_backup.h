// A good backup with the changes that an input tells, as somebody might send it to be restored.
// For the one thread that libFuzzer calls.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace motiondb::tests {

// An input is, after a byte whose lowest bit tells whether the backup gets a right checksum at its
// end, a list of changes, one behind the other. Each begins with its kind (1 byte):
//   0 mod 3: place (u32), length (1 byte) and bytes to write there;
//   1 mod 3: the same, where the place counts those bytes alone that are not zero;
//   2 mod 3: table, column and row (1 byte each), and a value (kind, length, bytes) to set there.
// Numbers are taken modulo what there is. Constraints of the tables do not hold here.
std::string ChangedBackup(const std::uint8_t* data, std::size_t size);

}  // namespace motiondb::tests
