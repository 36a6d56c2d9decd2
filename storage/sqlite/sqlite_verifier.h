// Checks an SQLite store: SqlVerifier, with SQLite's integrity check of the file.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <utility>
#include <vector>

#include "storage/sql/sql_verifier.h"

namespace motiondb::storage {

class SqliteVerifier final : public SqlVerifier {
 public:
  // `on_corrupt_index`: called by Step when it finds the search index to be corrupt. May be empty;
  // must stay valid as long as the verifier.
  SqliteVerifier(Read read, std::vector<Corruption> known, core::Cancelled cancelled,
                 std::function<void()> on_corrupt_index = {})
      : SqlVerifier(std::move(read), std::move(known), std::move(cancelled)),
        on_corrupt_index_(std::move(on_corrupt_index)) {}

 private:
  absl::Status CheckSchema(Connection& connection) override;
  absl::Status CheckFile(Connection& connection, std::int64_t& size) override;
  absl::Status CheckSearchIndex(Connection& connection) override;
  absl::Status CheckText(Connection& connection, std::int64_t clip_key,
                         const ClipText& text) override;
  absl::StatusOr<std::vector<ChangedRow>> FindChanged(Connection& connection,
                                                      std::string_view table) override;

  // Returns the error of a check of the index, with what to do.
  absl::Status OfCorruptIndex(const absl::Status& status);

  const std::function<void()> on_corrupt_index_;
  bool index_is_readable_ = true;
};

}  // namespace motiondb::storage
