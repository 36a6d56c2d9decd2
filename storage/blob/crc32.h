// CRC-32 (IEEE 802.3, as in zlib, gzip and PNG). Keeps no state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace motiondb::storage {

// Of bytes that follow others whose CRC-32 is `before`.
std::uint32_t Crc32(std::span<const std::byte> bytes, std::uint32_t before = 0);

}  // namespace motiondb::storage
