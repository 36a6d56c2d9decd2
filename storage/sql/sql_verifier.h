// Checks a store: the structure in the way of its engine, all chunks and rows by their checksums,
// and small items by decoding them.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/chunk_table.h"
#include "storage/sql/tables/clip_row.h"
#include "storage/sql/tables/table_lists.h"
#include "storage/store_maintenance.h"
#include "storage/text_query.h"

namespace motiondb::storage {

class SqlVerifier : public StoreVerifier {
 public:
  // Read runs a Look in its own read transaction: one long transaction would prevent freeing
  // space.
  using Look = std::function<absl::Status(Connection&)>;
  using Read = std::function<absl::Status(const Look&)>;

  // Only Step calls `read`; it must stay valid as long as the verifier. `known` is reported first.
  SqlVerifier(Read read, std::vector<Corruption> known, core::Cancelled cancelled)
      : read_(std::move(read)), cancelled_(std::move(cancelled)), found_(std::move(known)) {
    totals_.corruption_count = static_cast<std::int32_t>(found_.size());
  }

  absl::StatusOr<bool> Step(std::vector<Corruption>& found) override;
  double progress() const override;
  const VerifyTotals& totals() const override { return totals_; }

 protected:
  // What an engine checks in its own way. Errors are corruption, without a resource; those of
  // CheckFile and CheckSearchIndex are passed to Note.
  virtual absl::Status CheckSchema(Connection& connection) = 0;
  // Checks what the rows are stored in. `size`: about the bytes of the store.
  virtual absl::Status CheckFile(Connection& connection, std::int64_t& size) = 0;
  virtual absl::Status CheckSearchIndex(Connection& connection) = 0;
  // DATA_LOSS unless the search index was made from this text of a clip.
  virtual absl::Status CheckText(Connection& connection, std::int64_t clip_key,
                                 const ClipText& text) = 0;
  // Returns the rows of a checked table whose checksums do not match.
  virtual absl::StatusOr<std::vector<ChangedRow>> FindChanged(Connection& connection,
                                                              std::string_view table) = 0;

  // Adds an error to the found corruption; returns CANCELLED and RESOURCE_EXHAUSTED instead.
  absl::Status Note(const std::string& resource, const absl::Status& status);
  const core::Cancelled& cancelled() const { return cancelled_; }

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
  void Advance();

  const Read read_;
  const core::Cancelled cancelled_;
  Phase phase_ = Phase::kSchema;
  std::int64_t last_key_ = 0;    // last checked row (kRows: number of checked tables)
  std::int64_t file_bytes_ = 1;  // size of the store, for progress()
  VerifyTotals totals_;
  std::vector<Corruption> found_;
};

}  // namespace motiondb::storage
