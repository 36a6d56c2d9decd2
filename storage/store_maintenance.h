// Maintenance of a store while it is in use: verify, backup, restore, and export and import of
// single databases. The returned objects must be destroyed before the store. Only one thread may
// use an object at a time; several objects may be in use, also concurrently with other calls of the
// store.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "storage/access_store.h"
#include "storage/records.h"

namespace motiondb::storage {

// A corrupt item of the store.
struct Corruption {
  // The affected resource: `databases/d/clips/c`, `databases/d/models/3`, ...; empty: the file.
  std::string resource;
  std::string description;  // text for the operator
};

struct VerifyTotals {
  std::int32_t database_count = 0;
  std::int32_t clip_count = 0;
  std::int32_t model_count = 0;
  std::int32_t skeleton_count = 0;
  std::int64_t byte_count = 0;  // bytes of blobs
  std::int32_t corruption_count = 0;
};

// Reads the whole store in bounded memory. Each item is checked as it is when the verifier reads
// it.
class StoreVerifier {
 public:
  virtual ~StoreVerifier() = default;
  // Checks the next part (a few megabytes, or the structure of the file) and appends corrupt items
  // to `found`. Returns false after the last part. Corruption is not an error. CANCELLED.
  virtual absl::StatusOr<bool> Step(std::vector<Corruption>& found) = 0;
  virtual double progress() const = 0;  // 0 to 1
  virtual const VerifyTotals& totals() const = 0;
};

// A consistent copy of the store, or of one database, at one moment.
class StoreBackup {
 public:
  virtual ~StoreBackup() = default;
  virtual std::int64_t total_bytes() const = 0;
  // Reads the next bytes, at most 1 MiB. Returns false at the end. The last 32 bytes are the
  // SHA-256 of all bytes before them.
  virtual absl::StatusOr<bool> Read(std::string& block) = 0;
};

// Restores a backup: call Append until its end, then Check, then Finish. The store does not change
// before Finish, or if the object is destroyed instead. Check and Finish poll `cancelled` (Finish
// may do so on another thread) and return CANCELLED.
class StoreRestore {
 public:
  virtual ~StoreRestore() = default;
  // INVALID_ARGUMENT if the bytes are not a backup; RESOURCE_EXHAUSTED if the disk is full.
  virtual absl::Status Append(std::string_view bytes) = 0;
  // Reads and checks the whole backup. INVALID_ARGUMENT, with the reason, if the backup is corrupt
  // or cut off; FAILED_PRECONDITION if it has a newer version.
  virtual absl::Status Check(const core::Cancelled& cancelled) = 0;
  // Replaces the content of the store by the backup, atomically. Tokens and audit entries of the
  // store stay; those of the backup are added. If both contain a token, the store's is kept.
  // FAILED_PRECONDITION if the store now has a database, or the backup was not checked.
  virtual absl::Status Finish(const core::Cancelled& cancelled) = 0;
};

// Content of an exported database.
struct ExportedDatabase {
  DatabaseRecord record;  // with the name that it had
  std::int32_t clip_count = 0;
  std::int64_t frame_count = 0;
  std::int64_t byte_count = 0;  // of the blobs of its clips
};

// Adds an exported database to a store: call Append until its end, then Check, Stage and Publish.
// Check and Stage poll `cancelled` (Stage may do so on another thread) and return CANCELLED. If the
// object is destroyed before it has published, or the process ends, the content that Stage stored
// stays hidden and PurgeDeletedDatabases frees it.
class DatabaseImport {
 public:
  virtual ~DatabaseImport() = default;
  // INVALID_ARGUMENT if the bytes are not an exported database; RESOURCE_EXHAUSTED if the disk is
  // full.
  virtual absl::Status Append(std::string_view bytes) = 0;
  // Reads and checks the whole file. INVALID_ARGUMENT, with the reason, if it is corrupt or cut off
  // or does not have exactly one database; FAILED_PRECONDITION if it has a newer version.
  virtual absl::StatusOr<ExportedDatabase> Check(const core::Cancelled& cancelled) = 0;
  // Stores the content, hidden, in many short transactions; other writes run between them. Only one
  // call. FAILED_PRECONDITION if the file was not checked.
  virtual absl::Status Stage(const core::Cancelled& cancelled) = 0;
  // Makes the database visible as `database`, atomically. Clips, segments, edits, models and
  // revisions are those of the exported database; it has no operations. ALREADY_EXISTS if the store
  // has a database of this name; FAILED_PRECONDITION if the content is not staged.
  virtual absl::Status Publish(const std::string& database, const WriteOptions& terms = {}) = 0;
};

class StoreMaintenance {
 public:
  virtual ~StoreMaintenance() = default;
  // FAILED_PRECONDITION if the store is open read-only. Each change returns the same error.
  virtual absl::Status CheckIsWritable() const = 0;
  // Returns the corruption that was found when the store was opened and that can no longer be
  // detected. Every verification reports it too.
  virtual std::vector<Corruption> FoundAtOpening() const = 0;
  // UNAVAILABLE if the store's file was moved, deleted or replaced: changes would be lost. Each
  // change returns the same error. Costs one file status query.
  virtual absl::Status CheckFile() = 0;
  // Long steps poll `cancelled`, also from other threads; its captures must outlive the verifier.
  virtual absl::StatusOr<std::unique_ptr<StoreVerifier>> BeginVerify(core::Cancelled cancelled) = 0;
  // Writes a temporary copy beside the store, from which the result reads, and returns when the
  // copy is complete. The copy is deleted with the result; after a crash, when the store is next
  // opened. CANCELLED; RESOURCE_EXHAUSTED if the disk is full.
  virtual absl::StatusOr<std::unique_ptr<StoreBackup>> BeginBackup(
      const core::Cancelled& cancelled) = 0;
  // FAILED_PRECONDITION if the store has databases.
  virtual absl::StatusOr<std::unique_ptr<StoreRestore>> BeginRestore() = 0;
  // As BeginBackup, for one database: a backup of a store with this database alone, without
  // operations, tokens and audit entries. NOT_FOUND; DATA_LOSS if a row cannot be read.
  virtual absl::StatusOr<std::unique_ptr<StoreBackup>> BeginExport(
      const std::string& database, const core::Cancelled& cancelled) = 0;
  // While the import stages a database, Finish of a restore returns FAILED_PRECONDITION.
  virtual absl::StatusOr<std::unique_ptr<DatabaseImport>> BeginImport() = 0;
};

}  // namespace motiondb::storage
