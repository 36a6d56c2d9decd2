// A store that a client sends as a backup file, for a restore or an import: received into a file
// beside this store, checked, and upgraded.
#pragma once

#include <cstdint>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "storage/blob/checksums.h"
#include "storage/sql/connection/connection.h"
#include "storage/sqlite/store_disk.h"
#include "storage/sqlite/store_lock.h"

namespace motiondb::storage {

class ReceivedStore {
 public:
  // Words for the messages of errors.
  struct Wording {
    std::string purpose;    // "restore": also in the name of the file
    std::string noun;       // "backup"
    std::string program;    // "motiondb backup": it wrote the file
    std::string if_broken;  // what to do with a file whose content was corrupt when it was written
  };

  // `reserve` stays free while the file is received.
  static absl::StatusOr<std::unique_ptr<ReceivedStore>> Make(const std::string& store_path,
                                                             const DiskReserve& reserve,
                                                             Wording wording);

  // INVALID_ARGUMENT if the bytes are not a backup file; RESOURCE_EXHAUSTED if the disk is full.
  absl::Status Append(std::string_view bytes);
  // Reads and checks the whole file, after the last Append. Returns a connection to it, which the
  // object must outlive. INVALID_ARGUMENT, with the reason, if it is corrupt or cut off;
  // FAILED_PRECONDITION if it has a newer version; UNAVAILABLE if it was changed meanwhile.
  absl::StatusOr<std::unique_ptr<Connection>> Check(const core::Cancelled& cancelled);

  std::int64_t written_bytes() const { return written_bytes_; }  // so far, without the trailer

 private:
  ReceivedStore(const std::string& store_path, const DiskReserve& reserve, Wording wording)
      : wording_(std::move(wording)), reserve_(reserve), file_(store_path, wording_.purpose) {}
  absl::Status Write(std::string_view bytes);
  absl::Status CheckSum();
  // UNAVAILABLE if the received file was moved, replaced or changed.
  absl::Status CheckIsThere() const;
  absl::Status CheckWhole(Connection& connection, const core::Cancelled& cancelled) const;
  absl::Status NoBackup() const;
  // Names the file in an error. DATA_LOSS and INTERNAL become INVALID_ARGUMENT: the input is wrong,
  // this store is not corrupt.
  absl::Status OfFile(const absl::Status& status) const;

  const Wording wording_;
  const DiskReserve reserve_;
  CopyFile file_;
  std::ofstream stream_;
  FileIdentity opened_;
  std::int64_t written_bytes_ = 0;
  Sha256 digest_;
  std::string tail_;  // the last received bytes, which may be the trailer
  bool begun_ = false;
};

}  // namespace motiondb::storage
