// Backup and restore of a store, and export and import of a database, as a string.
#pragma once

#include <string>
#include <string_view>

#include "storage/motion_store.h"
#include "storage/sqlite/sqlite_backup.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/store_dump.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests {

// Returns any bytes as a backup with a valid checksum.
inline std::string Sealed(std::string bytes) {
  bytes += storage::kBackupMark;
  storage::Sha256 digest;
  digest.Update(bytes);
  return bytes + digest.Finish();
}

inline std::string BytesOf(storage::StoreBackup& backup) {
  std::string bytes;
  std::string block;
  while (Require(backup.Read(block))) {
    REQUIRE(block.size() <= storage::kBackupBlockBytes);
    bytes += block;
  }
  REQUIRE(static_cast<std::int64_t>(bytes.size()) == backup.total_bytes());
  return bytes;
}

inline std::string Backup(storage::MotionStore& store) {
  return BytesOf(*Require(store.maintenance().BeginBackup({})));
}

inline std::string Export(storage::MotionStore& store, const std::string& database) {
  return BytesOf(*Require(store.maintenance().BeginExport(database, {})));
}

inline absl::Status Import(storage::MotionStore& store, std::string_view bytes,
                           const std::string& database,
                           const storage::AuditRecord* audit = nullptr) {
  auto import = store.maintenance().BeginImport();
  if (!import.ok()) return import.status();
  absl::Status status = (*import)->Append(bytes);
  if (status.ok()) status = (*import)->Check({}).status();
  if (status.ok()) status = (*import)->Stage({});
  return status.ok() ? (*import)->Publish(database, {audit, {}}) : status;
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

// Restores a backup of a store in which the clips of database "d" are added in pairs, first N-x,
// then N-y, and removed in reverse: a snapshot that contains N-y must contain N-x.
inline void RequireWholePairs(const std::string& backup) {
  const StoreFile file;
  const auto target = file.Open();
  REQUIRE_OK(Restore(*target, backup));
  REQUIRE(Findings(*target).empty());
  for (const auto& found : Require(target->ListClips("d", {.limit = 100'000}))) {
    if (!found.id.ends_with("-y")) continue;
    REQUIRE_OK(target->GetClip("d", found.id.substr(0, found.id.size() - 1) + "x"));
  }
}

}  // namespace motiondb::tests
