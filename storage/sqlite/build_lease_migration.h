// The migration of a store to version 12 (migrations.cc).
#pragma once

namespace motiondb::storage {

// The last lease to build the models of a database (for stores that servers share), and the index
// of the operations that have not ended.
inline constexpr char kBuildLeases[] = R"sql(
CREATE TABLE build_lease (
  database_key INTEGER PRIMARY KEY REFERENCES database ON DELETE CASCADE,
  holder TEXT NOT NULL,             -- '': released
  fence INTEGER NOT NULL,           -- rises with each lease
  expire_time_us INTEGER NOT NULL,
  row_crc INTEGER
) STRICT;
CREATE INDEX unfinished_operation ON operation (sequence) WHERE state IN ('pending', 'running');
)sql";

}  // namespace motiondb::storage
