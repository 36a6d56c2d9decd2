// Checks an SQLite store: the file with SQLite's integrity check, all chunks and rows by their
// checksums, and small items by decoding them.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "storage/sqlite/chunk_table.h"
#include "storage/sqlite/clip_row.h"
#include "storage/sqlite/connection.h"
#include "storage/store_maintenance.h"

namespace motiondb::storage {

class SqliteVerifier final : public StoreVerifier {
 public:
  // Read runs a Look in its own read transaction: one long transaction would prevent emptying the
  // log.
  using Look = std::function<absl::Status(Connection&)>;
  using Read = std::function<absl::Status(const Look&)>;

  // Only Step calls `read` and `on_corrupt_index`, which may be empty; they must stay valid as long
  // as the verifier. `known` is reported first.
  SqliteVerifier(Read read, std::vector<Corruption> known, core::Cancelled cancelled,
                 std::function<void()> on_corrupt_index = {})
      : read_(std::move(read)),
        on_corrupt_index_(std::move(on_corrupt_index)),
        cancelled_(std::move(cancelled)),
        found_(std::move(known)) {
    totals_.damage_count = static_cast<std::int32_t>(found_.size());
  }

  absl::StatusOr<bool> Step(std::vector<Corruption>& found) override;
  double progress() const override;
  const VerifyTotals& totals() const override { return totals_; }

 private:
  enum class Phase {
    kSchema,
    kFile,
    kSearch,
    kClips,
    kSkeletons,
    kModels,
    kEdits,
    kRecords,
    kRows,
    kDone
  };

  absl::Status CheckFile(Connection& connection);
  absl::Status CheckSearchIndex(Connection& connection);
  // Notes that the index is corrupt, with the words of a clip if `resource` is not empty.
  absl::Status NoteCorruptIndex(const std::string& resource, const absl::Status& status);
  // Each checks the row after `last_key_`. Returns false if there is none.
  absl::StatusOr<bool> CheckClip(Connection& connection);
  absl::StatusOr<bool> CheckSkeleton(Connection& connection);
  absl::StatusOr<bool> CheckModel(Connection& connection);
  absl::StatusOr<bool> CheckNextEdit(Connection& connection);
  absl::Status CheckRecords(Connection& connection);
  // Checks the row checksums of table number `last_key_`.
  absl::Status CheckRows(Connection& connection);

  // Checks the record of a clip, its segments and its searched text.
  absl::Status CheckAnnotations(Connection& connection, const ClipRef& clip);
  // Checks that a blob is complete and that its chunks are valid.
  absl::Status CheckBytes(Connection& connection, const BlobOwner& owner, BlobKind kind);
  absl::Status CheckStates(Connection& connection, std::int64_t clip_key, std::int32_t frames,
                           std::uint32_t root_path_crc);
  absl::Status CheckModelParts(Connection& connection, std::int64_t built_key,
                               std::int64_t clip_count, std::int64_t frame_count);
  // Adds an error to the found corruption; returns CANCELLED and RESOURCE_EXHAUSTED instead.
  absl::Status Note(const std::string& resource, const absl::Status& status);
  void Advance();

  const Read read_;
  const std::function<void()> on_corrupt_index_;
  const core::Cancelled cancelled_;
  Phase phase_ = Phase::kSchema;
  std::int64_t last_key_ = 0;    // last checked row (kRows: number of checked tables)
  std::int64_t file_bytes_ = 1;  // size of the file, for progress()
  bool index_is_readable_ = true;
  VerifyTotals totals_;
  std::vector<Corruption> found_;
};

}  // namespace motiondb::storage
