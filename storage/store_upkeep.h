// Care for a store as a whole while it is in use: checking all of it, copying it, filling it from a
// copy. What is begun here must end before the store does; each object serves one thread at a time,
// any number of them beside all else that the store does.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"

namespace motiondb::storage {

// Something stored that is damaged.
struct Damage {
  // What it costs: `databases/d/clips/c`, `databases/d/models/3`, ...; empty: the file itself.
  std::string resource;
  std::string description;  // for a person
};

struct VerifyTotals {
  std::int32_t database_count = 0;
  std::int32_t clip_count = 0;
  std::int32_t model_count = 0;
  std::int32_t skeleton_count = 0;
  std::int64_t byte_count = 0;  // of blobs
  std::int32_t damage_count = 0;
};

// Reads everything that is stored, each thing as it stands at its turn, in bounded memory.
class StoreVerifier {
 public:
  virtual ~StoreVerifier() = default;
  // Checks a further part, a few megabytes or the file's own structure, and adds what is damaged to
  // `found`. False once everything was checked. Damage is no error; CANCELLED is.
  virtual absl::StatusOr<bool> Step(std::vector<Damage>& found) = 0;
  virtual double progress() const = 0;  // 0 to 1
  virtual const VerifyTotals& totals() const = 0;
};

// A copy of the store as it was at one moment.
class StoreBackup {
 public:
  virtual ~StoreBackup() = default;
  virtual std::int64_t total_bytes() const = 0;
  // The next bytes, at most 1 MiB; false at the end. The last 32 are the SHA-256 of those before.
  virtual absl::StatusOr<bool> Read(std::string& block) = 0;
};

// A backup on its way in: Append to its end, Check, Finish. Nothing changes before Finish, or if it
// is destroyed instead. Check and Finish ask `cancelled` as they go, Finish perhaps from another
// thread: CANCELLED.
class StoreRestore {
 public:
  virtual ~StoreRestore() = default;
  // INVALID_ARGUMENT if these are not the bytes of a backup; RESOURCE_EXHAUSTED if the disk is
  // full.
  virtual absl::Status Append(std::string_view bytes) = 0;
  // Checks the whole of it, which takes as long as reading it does. INVALID_ARGUMENT, saying what
  // is wrong, if the backup is damaged or cut off; FAILED_PRECONDITION if it is of a newer version.
  virtual absl::Status Check(const core::Cancelled& cancelled) = 0;
  // Makes it what is stored, at once or not at all. Tokens and records of changes that the store
  // has stay valid, and those of the backup come to them; where both know a token, the store's
  // stands. FAILED_PRECONDITION if the store has a database by now, or the backup was not checked.
  virtual absl::Status Finish(const core::Cancelled& cancelled) = 0;
};

class StoreUpkeep {
 public:
  virtual ~StoreUpkeep() = default;
  // FAILED_PRECONDITION, as from each change, if the store is open read-only.
  virtual absl::Status CheckIsWritable() const = 0;
  // What was found corrupt when the store was opened, and nothing shows any more since. Every
  // verification reports it too.
  virtual std::vector<Damage> FoundAtOpening() const = 0;
  // Whether what is changed would stay: UNAVAILABLE, as from each change, once the store's file was
  // taken away or replaced. Takes as long as looking at a folder does.
  virtual absl::Status CheckFile() = 0;
  // `cancelled` is asked during long steps, as long as the verifier lives, also from other threads.
  virtual absl::StatusOr<std::unique_ptr<StoreVerifier>> BeginVerify(core::Cancelled cancelled) = 0;
  // Takes as long as the disk needs to write the copy beside the store, from where it is then read;
  // it is gone when the result is, or, after a crash, when the store is next opened. CANCELLED;
  // RESOURCE_EXHAUSTED if the disk is full.
  virtual absl::StatusOr<std::unique_ptr<StoreBackup>> BeginBackup(
      const core::Cancelled& cancelled) = 0;
  // FAILED_PRECONDITION unless the store is without databases.
  virtual absl::StatusOr<std::unique_ptr<StoreRestore>> BeginRestore() = 0;
};

}  // namespace motiondb::storage
