// Checks a SQLite store: the file by SQLite's integrity check, every chunk of every blob by its
// checksum, and what is cheap to decode by decoding it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "storage/sqlite/chunk_table.h"
#include "storage/sqlite/connection.h"
#include "storage/store_upkeep.h"

namespace motiondb::storage {

class SqliteVerifier final : public StoreVerifier {
 public:
  // Runs a read on a connection, in a transaction of its own, so that a long verification does not
  // keep the log from being emptied.
  using Look = std::function<absl::Status(Connection&)>;
  using Read = std::function<absl::Status(const Look&)>;

  // `read` is called by Step alone and must stay good as long as the verifier. `known` is reported
  // first.
  SqliteVerifier(Read read, std::vector<Damage> known, core::Cancelled cancelled)
      : read_(std::move(read)), cancelled_(std::move(cancelled)), found_(std::move(known)) {
    totals_.damage_count = static_cast<std::int32_t>(found_.size());
  }

  absl::StatusOr<bool> Step(std::vector<Damage>& found) override;
  double progress() const override;
  const VerifyTotals& totals() const override { return totals_; }

 private:
  enum class Phase { kSchema, kFile, kClips, kSkeletons, kModels, kRecords, kRows, kDone };

  absl::Status CheckFile(Connection& connection);
  // Each checks one row, the one after `last_key_`. False if there is none.
  absl::StatusOr<bool> CheckClip(Connection& connection);
  absl::StatusOr<bool> CheckSkeleton(Connection& connection);
  absl::StatusOr<bool> CheckModel(Connection& connection);
  absl::Status CheckRecords(Connection& connection);
  // The checksums of the rows of one table, the one after `last_key_` tables.
  absl::Status CheckRows(Connection& connection);

  // Checks every chunk of a blob, and that the bytes are all there.
  absl::Status CheckBytes(Connection& connection, const BlobOwner& owner, BlobKind kind);
  absl::Status CheckStates(Connection& connection, std::int64_t clip_key, std::int32_t frames,
                           std::uint32_t root_path_crc);
  absl::Status CheckModelParts(Connection& connection, std::int64_t built_key,
                               std::int64_t clip_count, std::int64_t frame_count);
  // Keeps damage; returns what is an error of another kind.
  absl::Status Note(const std::string& resource, const absl::Status& status);
  void Advance();

  const Read read_;
  const core::Cancelled cancelled_;
  Phase phase_ = Phase::kSchema;
  std::int64_t last_key_ = 0;    // of the rows of this phase that were checked
  std::int64_t file_bytes_ = 1;  // the blobs have no more
  VerifyTotals totals_;
  std::vector<Damage> found_;
};

}  // namespace motiondb::storage
