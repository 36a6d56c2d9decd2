// What a backup file is: a store's file, all pages of one moment, and after it a mark and the
// SHA-256 of all that is before. SQLite takes no notice of bytes behind its last page.
#pragma once

#include <cstddef>
#include <string_view>

#include "storage/blob/sha256.h"

namespace motiondb::storage {

inline constexpr std::string_view kBackupMark = "mtdbback";
inline constexpr std::size_t kBackupTrailerBytes = kBackupMark.size() + kSha256Bytes;
inline constexpr std::size_t kBackupBlockBytes = 1 << 20;

}  // namespace motiondb::storage
