// Backup and restore of a store as a string.
#pragma once

#include <string>
#include <string_view>

#include "storage/motion_store.h"
#include "storage/sqlite/sqlite_backup.h"
#include "tests/storage/require_ok.h"

namespace motiondb::tests {

inline std::string Backup(storage::MotionStore& store) {
  const auto backup = Require(store.maintenance().BeginBackup({}));
  std::string bytes;
  std::string block;
  while (Require(backup->Read(block))) {
    REQUIRE(block.size() <= storage::kBackupBlockBytes);
    bytes += block;
  }
  REQUIRE(static_cast<std::int64_t>(bytes.size()) == backup->total_bytes());
  return bytes;
}

inline absl::Status Restore(storage::MotionStore& store, std::string_view bytes,
                            std::size_t block = 100'000) {
  auto restore = store.maintenance().BeginRestore();
  if (!restore.ok()) return restore.status();
  for (std::size_t begin = 0; begin < bytes.size(); begin += block) {
    const absl::Status taken = (*restore)->Append(bytes.substr(begin, block));
    if (!taken.ok()) return taken;
  }
  const absl::Status checked = (*restore)->Check({});
  return checked.ok() ? (*restore)->Finish({}) : checked;
}

}  // namespace motiondb::tests
